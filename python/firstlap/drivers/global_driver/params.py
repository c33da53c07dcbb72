"""Parameters of the map-based driver: those of its parts, in prefixed sections, and of its guard."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from firstlap import _core
from firstlap.config.driver_kind import TableParams
from firstlap.config.parameters import FieldTable, Value
from firstlap.config.table import row, table_of
from firstlap.control.mpc.params import MpcParams
from firstlap.mapping.parameters import MAP_FIELDS, MapSettings
from firstlap.planning.raceline.params import LineParams

MAP, POSE = "map_", "pose_"
"""Prefixes of the sections of mapping and of localization."""


@dataclass(frozen=True)
class GuardParams:
    """Parameters of the guard, see docs/global-driver.md."""

    true_pose: bool = row(False, "", 0, 1, "use the simulator's true pose: for ablation only")
    brake_use: float = row(0.9, "", 0.1, 1.0, "share of the tires' grip that a stop may use, including cornering")
    lost_pause: float = row(
        0.2, "s", 0.0, 1.0, "how long the plan is followed, braking, without a pose; then the car steers by the scan"
    )
    jump: float = row(0.4, "m", 0.05, 5.0, "a pose this far from the expected one resets the controller")
    shrink: float = row(
        0.05, "m", 0.0, 0.15, "a return blocks the plan if it is this deep inside the area that the car will sweep"
    )
    doubt: float = row(0.004, "", 0.0, 0.1, "increase of that depth per meter of distance, for heading errors")
    blocking: int = row(2, "", 1, 100, "number of returns that block the plan")
    blocked_scans: int = row(2, "", 1, 20, "consecutive scans that must show the obstacle")
    gap: float = row(0.3, "m", 0.0, 2.0, "distance to an obstacle at which the car stops")
    start_fit: float = row(0.9, "", 0.0, 1.0, "share of the scan that must match the map before the car first moves")
    search_after: float = row(0.4, "s", 0.0, 60.0, "a stopped, lost car searches the whole map after this time")
    search_fit: float = row(0.85, "", 0.0, 1.0, "share of the scan that must match at a pose found by the search")
    searches: int = row(3, "", 0, 100, "maximum number of searches")


@dataclass(frozen=True)
class Parts:
    """Parameters of the driver's parts."""

    mapping: MapSettings
    localizer: _core.LocalizerParams
    line: LineParams
    mpc: MpcParams
    guard: GuardParams


def _prefixed(fields: list[dict[str, Any]], prefix: str) -> Iterator[Mapping[str, Any]]:
    for entry in fields:
        yield {**entry, "section": prefix + entry["section"]}


def _rows() -> Iterator[Mapping[str, Any]]:
    for table in (table_of(guard=GuardParams), table_of(mpc=MpcParams), table_of(line=LineParams)):
        for entry in table.fields:
            yield vars(entry)
    yield from _prefixed(_core.LocalizerParams.fields(), POSE)
    yield from _prefixed(_core.MapParams.fields(), MAP)


GLOBAL_FIELDS = FieldTable(_rows())
Section = TypeVar("Section")


class GlobalParams(TableParams):
    """Values of `GLOBAL_FIELDS`."""

    def __init__(self) -> None:
        super().__init__(GLOBAL_FIELDS)

    def validate(self) -> None:
        """Raises ValueError if values contradict each other."""
        self.parts()

    def parts(self) -> Parts:
        """The parameters of each part. Raises ValueError."""
        values = self.values()
        localizer, mapping = _core.LocalizerParams(), _core.MapParams()
        for params, prefix in ((localizer, POSE), (mapping, MAP)):
            for section, content in values.items():
                if section.startswith(prefix):
                    for name, value in content.items():
                        params.set(section.removeprefix(prefix), name, value)
            params.validate()
        changed: dict[str, Value] = {
            entry.key: value
            for entry in MAP_FIELDS.fields
            if (value := values[MAP + entry.section][entry.name]) != entry.default
        }
        return Parts(
            MapSettings(mapping, changed),
            localizer,
            LineParams(**values["line"]),
            MpcParams(**values["mpc"]),
            GuardParams(**values["guard"]),
        )
