"""The parameters of mapping, from the field tables of cpp/firstlap/mapping/params.hpp."""

from __future__ import annotations

from dataclasses import dataclass

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.parameters import FieldTable, Value

MAP_FIELDS = FieldTable(_core.MapParams.fields())


@dataclass(frozen=True)
class MapSettings:
    """All parameters of mapping. changed: values that differ from the defaults."""

    core: _core.MapParams
    changed: dict[str, Value]

    def get(self, key: str) -> float:
        """The value of section.name."""
        section, _, name = key.partition(".")
        return float(self.core.get(section, name))  # type: ignore[arg-type]


def map_settings(assignments: list[str] | None = None) -> MapSettings:
    """The defaults with changes such as "grid.resolution=0.05". Raises InputError."""
    core, changed = _core.MapParams(), {}
    for text in assignments or []:
        field, value = MAP_FIELDS.parse_assignment(text)
        core.set(field.section, field.name, value)
        changed[field.key] = value
    try:
        core.validate()
    except ValueError as error:
        raise InputError(f"--set: {error}") from None
    return MapSettings(core, changed)
