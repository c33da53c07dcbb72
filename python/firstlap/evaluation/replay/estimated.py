"""A recording with estimated instead of recorded states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.recordings.recording import Recording

Floats = npt.NDArray[np.float64]

SOURCE = "state estimate"
STATE = tuple(column["name"] for column in _core.VehicleState.columns())
ESTIMATES = tuple(column["name"] for column in _core.MotionEstimate.columns())


def with_estimate(recording: Recording, car: Car) -> Recording:
    """Replaces the states by estimates from the recorded wheel speed, IMU, steering angle and commands.

    Raises InputError if it has no odometry.
    """
    readings = readings_of(recording)
    commands = np.full((len(recording), 2), np.nan)
    if recording.commands is not None:
        before = np.column_stack([recording.commands.speed, recording.commands.steering_angle])
        commands[1:] = before[:-1]
    rows = np.asarray(_core.estimate_all(car.core, readings, commands, np.ascontiguousarray(recording.dts)))
    states = np.ascontiguousarray(rows[:, [ESTIMATES.index(name) for name in STATE]])
    return replace(recording, states=states, sources={**recording.sources, **dict.fromkeys(STATE, SOURCE)})


def readings_of(recording: Recording) -> Floats:
    """(N, 5) rows of the table of SensorReading, NaN where there is no measurement. Raises InputError."""
    sources = recording.sources
    if not sources["speed"].startswith("odometry"):
        raise InputError(f"{recording.source}: no wheel speed to estimate the state from: its speed is from "
                         f"{sources['speed']}")  # fmt: skip
    readings = np.full((len(recording), 5), np.nan)
    readings[:, 0] = recording.speed
    if sources["yaw_rate"].startswith(("odometry", "imu")):
        readings[:, 1] = recording.yaw_rate
    if sources["steering_angle"].startswith("measured"):
        readings[:, 2] = recording.steering_angle
    if recording.acceleration is not None:
        readings[:, 3:] = recording.acceleration
    return readings
