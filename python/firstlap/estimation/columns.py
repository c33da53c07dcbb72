"""The columns of the state estimate's inputs and results, in the order of the core's tables."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from firstlap import _core

Floats = npt.NDArray[np.float64]


def _names(
    record: type[_core.SensorReading | _core.MotionEstimate | _core.VehicleState],
) -> tuple[str, ...]:
    return tuple(column["name"] for column in record.columns())


READINGS = _names(_core.SensorReading)
COMMANDS = ("speed", "steering_angle")
"""[m/s], [rad]"""
ESTIMATES = _names(_core.MotionEstimate)
STATE = _names(_core.VehicleState)


def in_columns(names: tuple[str, ...], known: Mapping[str, Floats], rows: int) -> Floats:
    """(rows, K) values in columns of these names, NaN where nothing is known; known: (rows,) each, by name."""
    unnamed = set(known) - set(names)
    if unnamed:
        raise KeyError(f"no such column: {', '.join(sorted(unnamed))}")
    unknown = np.full(rows, np.nan)
    return np.column_stack([known.get(name, unknown) for name in names])


def estimates_from(car: _core.Car, readings: Floats, commands: Floats, dts: Floats) -> dict[str, Floats]:
    """The estimates by name, (N,) each.

    readings, commands: (N, K) in the columns READINGS and COMMANDS; a command is the one in effect before the reading.
    dts: (N,) [s] before each reading.
    """
    inputs = (np.ascontiguousarray(values, dtype=np.float64) for values in (readings, commands, dts))
    rows = np.asarray(_core.estimate_all(car, *inputs))
    return dict(zip(ESTIMATES, rows.T, strict=True))
