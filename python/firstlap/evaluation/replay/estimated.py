"""A recording with estimated instead of recorded states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.estimation.columns import COMMANDS, READINGS, STATE, estimates_from, in_columns
from firstlap.recordings.recording import Recording

Floats = npt.NDArray[np.float64]

SOURCE = "state estimate"


def with_estimate(recording: Recording, car: Car) -> Recording:
    """Replaces the states by estimates from the recorded wheel speed, IMU, steering angle and commands.

    Raises InputError if it has no odometry.
    """
    found = estimates_from(car.core, readings_of(recording), _commands_before(recording), recording.dts)
    states = np.ascontiguousarray(np.column_stack([found[name] for name in STATE]))
    return replace(recording, states=states, sources={**recording.sources, **dict.fromkeys(STATE, SOURCE)})


def _commands_before(recording: Recording) -> Floats:
    """(N, K) the command in effect before each scan in the columns COMMANDS, NaN where it is not known."""
    known = {} if recording.commands is None else {name: getattr(recording.commands, name) for name in COMMANDS}
    commands = in_columns(COMMANDS, known, len(recording))
    return np.vstack([np.full_like(commands[:1], np.nan), commands[:-1]])


def readings_of(recording: Recording) -> Floats:
    """(N, K) the readings in the columns READINGS, NaN where there is no measurement. Raises InputError."""
    sources = recording.sources
    if not sources["speed"].startswith("odometry"):
        raise InputError(f"{recording.source}: no wheel speed to estimate the state from: its speed is from "
                         f"{sources['speed']}")  # fmt: skip
    measured = {"wheel_speed": recording.speed}
    # Nodes of motor controllers calculate the yaw rate of the odometry from speed and steering angle.
    if recording.gyro is not None:
        measured["yaw_rate"] = recording.gyro
    elif sources["yaw_rate"].startswith("odometry"):
        measured["yaw_rate"] = recording.yaw_rate
    if sources["steering_angle"].startswith("measured"):
        measured["steering_angle"] = recording.steering_angle
    if recording.acceleration is not None:
        measured["acceleration_x"], measured["acceleration_y"] = recording.acceleration.T
    return in_columns(READINGS, measured, len(recording))
