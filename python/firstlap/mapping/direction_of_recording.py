"""Compares the direction of travel by a recording's commanded speed with that by its scans."""

from __future__ import annotations

import math

import numpy as np

from firstlap.config.car_file import Car
from firstlap.estimation.odometry_check import ENOUGH_WAY, FEWEST_STEPS, GROSS, NOTABLE_ANGLE
from firstlap.mapping.odometry_of_recording import pieces, steps_of
from firstlap.recordings import Recording
from firstlap.recordings.laser import OPTION
from firstlap.tracks.track import FloatArray

COMMANDED = "commands"
"""Prefix of `Recording.sources` for commanded speeds; measured speeds are checked with the odometry."""


def remarks_on_direction(recording: Recording, car: Car) -> tuple[str, ...]:
    """One line if the directions by scans and by commands differ: the LiDAR is mounted differently."""
    source = recording.sources.get("speed", "none")
    if not source.startswith(COMMANDED):
        return ()
    told, seen = _motions(recording, car)
    # In the sum, noise and the delay of the commands are small.
    way, motion = float(np.abs(told).sum()), np.sign(told) @ seen
    went = float(np.hypot(*motion))
    if len(told) < FEWEST_STEPS or min(way, went) < ENOUGH_WAY or not 1.0 / GROSS < went / way < GROSS:
        return ()
    angle = math.degrees(math.atan2(motion[1], motion[0]))
    if abs(angle) < NOTABLE_ANGLE:
        return ()
    mounted = 0.0 if recording.laser is None else math.degrees(recording.laser.yaw)
    yaw = math.remainder(mounted - angle, 360.0)
    return (
        f"the car drives forward by its {source}, but {abs(angle):.0f}° to the {'left' if angle > 0.0 else 'right'} of "
        f"that by its scans: is the LiDAR mounted differently? Set {OPTION} X,Y,YAW, here with a yaw near {yaw:.0f}",
    )


def _motions(recording: Recording, car: Car) -> tuple[FloatArray, FloatArray]:
    """(K,) distance by speed and (K, 2) forward and left motion by scans [m], for the steps that have both."""
    dts = np.diff(recording.stamps, prepend=recording.stamps[0])
    way = np.cumsum(recording.speed * dts)
    told, seen = [np.zeros(0)], [np.zeros((0, 2))]
    for begin, end in pieces(recording.duration):
        steps = steps_of(recording, car, begin, end)
        good = np.isfinite(steps.motion).all(axis=1)
        ways = np.interp(steps.ends, recording.stamps, way) - np.interp(steps.begins, recording.stamps, way)
        told.append(ways[good])
        seen.append(steps.motion[good, :2])
    return np.concatenate(told), np.concatenate(seen)
