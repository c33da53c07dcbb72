"""Recordings as input of the mapper: scans, and odometry from the recorded speed and yaw rate."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from firstlap.common.errors import InputError
from firstlap.mapping.observation import Observation, motion_of
from firstlap.mapping.poses import between
from firstlap.recordings import Recording
from firstlap.tracks.track import FloatArray


def check_odometry(recording: Recording) -> None:
    """Raises InputError if the recording has no motion of the car."""
    if recording.sources.get("speed", "none") == "none" and _odometry(recording) is None:
        raise InputError(
            f"{recording.source}: no odometry; a map needs the car's speed and yaw rate, or its Ackermann commands"
        )


def observations(recording: Recording) -> Iterator[Observation]:
    """Yields the observations. Recorded poses are used only if they are from odometry, not from a map."""
    poses = _odometry(recording)
    motions = _from_states(recording) if poses is None else np.vstack([np.zeros(3), between(poses[:-1], poses[1:])])
    for i in range(len(recording)):
        yield Observation(
            time=float(recording.stamps[i]),
            speed=float(recording.speed[i]),
            yaw_rate=float(recording.yaw_rate[i]),
            motion=motions[i],
            scan=partial(recording.scan, i),
        )


def _odometry(recording: Recording) -> FloatArray | None:
    """(N, 3) odometry poses, if the recording has them."""
    return recording.poses if recording.odometry is None and recording.frame == "odom" else recording.odometry


def _from_states(recording: Recording) -> FloatArray:
    states = recording.states
    mean = 0.5 * (states[1:] + states[:-1])
    dts = np.diff(recording.stamps)
    steps = [motion_of(speed, rate, dt) for (speed, rate, _), dt in zip(mean, dts, strict=True)]
    return np.vstack([np.zeros(3), *steps])
