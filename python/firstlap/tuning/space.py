"""The search space: parameters, their ranges, and candidates as points in the unit cube."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field, FieldTable, Value, Values
from firstlap.config.setup_file import Setup

REACH = 2.0
DIGITS = 4
TUNED = {
    "local": (
        "trajectory.smoothing_iterations",
        "trajectory.smoothing_margin",
        "velocity_profile.v_min",
        "velocity_profile.v_max",
        "velocity_profile.a_x_max",
        "velocity_profile.a_x_min",
        "velocity_profile.a_y_max",
        "velocity_profile.preview_time",
        "velocity_profile.delta_v_max",
        "velocity_profile.delta_v_min",
        "velocity_profile.v_horizon",
        "stanley.k_ang",
        "stanley.k_dist",
        "stanley.k_soft",
        "stanley.k_rate",
        "stanley.l_max",
        "stanley.schedule_omega",
    )
}
"""Parameters tuned by default; for drivers not listed here, all except the car's geometry."""

Point = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """One parameter with its search range, which is within the range of its field table."""

    field: Field
    low: float
    high: float

    @property
    def log(self) -> bool:
        """Whether the scale is logarithmic."""
        return self.low > 0.0 and self.high / self.low >= 3.0

    def to_unit(self, value: float) -> float:
        """Maps a value to 0 to 1."""
        value = min(max(float(value), self.low), self.high)
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def from_unit(self, unit: float) -> Value:
        """Maps 0 to 1 to a value, rounded as it is written and raced."""
        value = self.low * (self.high / self.low) ** unit if self.log else self.low + unit * (self.high - self.low)
        if self.field.type != "float":
            return round(value)
        return float(f"{min(max(value, self.low), self.high):.{DIGITS}g}")


class Space:
    """The parameters that a search changes."""

    def __init__(self, axes: Sequence[Axis]) -> None:
        self.axes = list(axes)

    def to_unit(self, setup: Setup) -> Point:
        """(n,) the setup as a point."""
        return np.array([axis.to_unit(float(setup.get(axis.field.key))) for axis in self.axes])

    def values(self, point: Point) -> Values:
        """The parameters at a point."""
        return {
            (axis.field.section, axis.field.name): axis.from_unit(float(unit))
            for axis, unit in zip(self.axes, point, strict=True)
        }

    def to_dict(self) -> dict[str, list[float]]:
        """{section.name: [low, high]}"""
        return {axis.field.key: [axis.low, axis.high] for axis in self.axes}


def make_space(setups: Sequence[Setup], only: str | None, fix: str | None) -> Space:
    """The space around setups of one driver; only, fix: comma-separated names. Raises InputError.

    A range goes from half the smallest to twice the largest value of the setups, within the range of the field.
    """
    driver = setups[0].driver
    table = setups[0].fields
    wanted = _names(only, table, "--only") if only is not None else usual(driver, table)
    fixed = _names(fix, table, "--fix") if fix is not None else []
    axes = [axis_around(field, [float(s.get(field.key)) for s in setups]) for field in wanted if field not in fixed]
    axes = [axis for axis in axes if axis.high > axis.low]
    if not axes:
        raise InputError("--fix: no parameter is left to tune" if fix else f"driver {driver}: nothing can be tuned")
    return Space(axes)


def axis_around(field: Field, values: Sequence[float]) -> Axis:
    """The range for one parameter, from its values in the setups."""
    if field.type == "bool":
        return Axis(field, field.min, field.max)
    size = max(abs(value) for value in values)
    if size == 0.0:
        size = 0.05 * (field.max - field.min)
    low = min(v / REACH if v > 0.0 else v * REACH for v in values)
    high = max(v * REACH if v > 0.0 else v / REACH for v in values)
    if min(values) <= 0.0 <= max(values) and field.min < 0.0:
        low = min(low, -size)
    if min(values) <= 0.0 <= max(values):
        high = max(high, size)
    low, high = max(low, field.min), min(high, field.max)
    if field.type == "int":
        low, high = math.floor(low), math.ceil(high)
    return Axis(field, float(f"{low:.{DIGITS}g}"), float(f"{high:.{DIGITS}g}"))


def usual(driver: str, table: FieldTable) -> list[Field]:
    """The parameters tuned by default."""
    if driver in TUNED:
        return [table.find(name, "tune") for name in TUNED[driver]]
    return [field for field in table.fields if field.section != "car"]


def _names(text: str, table: FieldTable, option: str) -> list[Field]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise InputError(f"{option}: expected comma-separated parameter names, for example k_ang,l_max")
    return [table.find(name, option) for name in names]
