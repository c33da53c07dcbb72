"""Every parameter of the map-based driver: those of its parts, under prefixed sections, and of its safety net."""

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
    """When the driver does not trust itself. See docs/global-driver.md."""

    true_pose: bool = row(False, "", 0, 1, "drive by the simulator's own pose: an ablation, never an opponent")
    brake_use: float = row(0.9, "", 0.1, 1.0, "share of the tires' grip that a stop may use, cornering included")
    lost_pause: float = row(0.2, "s", 0.0, 1.0, "without a pose the plan is followed for so long, braking; then scans")
    jump: float = row(0.4, "m", 0.05, 5.0, "a pose this far from the expected one starts the controller anew")
    shrink: float = row(0.05, "m", 0.0, 0.15, "a return this deep inside the planned sweep of the car blocks it")
    doubt: float = row(0.004, "", 0.0, 0.1, "and so much deeper per meter of way to it: the heading is not exact")
    blocking: int = row(2, "", 1, 100, "returns that it takes to block the plan")
    blocked_scans: int = row(2, "", 1, 20, "scans in a row that must see it")
    gap: float = row(0.3, "m", 0.0, 2.0, "distance to what blocks the plan at which the car stands")
    start_fit: float = row(0.9, "", 0.0, 1.0, "share of the scan that must fit once before the car first moves")
    search_after: float = row(0.4, "s", 0.0, 60.0, "a car that stands lost for so long seeks itself on the whole map")
    search_fit: float = row(
        0.85, "", 0.0, 1.0, "share of the scan that must fit where it believes to have found itself"
    )
    searches: int = row(3, "", 0, 100, "times that it does so before it stays where it is")


@dataclass(frozen=True)
class Parts:
    """What the parts of the driver are made with."""

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
        """Raises ValueError where values contradict each other."""
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
