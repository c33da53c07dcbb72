"""The input of the mapper: scans, and odometry between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firstlap import _core
from firstlap.tracks.track import FloatArray


@dataclass(frozen=True)
class Observation:
    """One scan and the measured state at its end.

    motion: (3,) pose of base_link in its frame at the previous scan, from odometry alone.
    scan: returns the sweep; called only when needed.
    """

    time: float
    speed: float
    yaw_rate: float
    motion: FloatArray
    scan: Callable[[], _core.LaserScan]


def motion_of(speed: float, yaw_rate: float, dt: float) -> FloatArray:
    """(3,) pose of base_link after dt seconds in its frame before, along an arc."""
    turn = yaw_rate * dt
    return np.array([speed * dt * np.cos(0.5 * turn), speed * dt * np.sin(0.5 * turn), turn])
