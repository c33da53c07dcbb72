"""What a mapper sees: scans, and odometry between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firstlap.perception.scan import Scan
from firstlap.tracks.track import FloatArray


@dataclass(frozen=True)
class Observation:
    """One scan and the measured state at its end.

    motion: (3,) base_link now as seen from base_link at the scan before, from odometry alone.
    scan: gives the sweep; asked for only when it is needed.
    """

    time: float
    speed: float
    yaw_rate: float
    motion: FloatArray
    scan: Callable[[], Scan]


def motion_of(speed: float, yaw_rate: float, dt: float) -> FloatArray:
    """(3,) where base_link is after dt seconds, as seen from before: along an arc."""
    turn = yaw_rate * dt
    return np.array([speed * dt * np.cos(0.5 * turn), speed * dt * np.sin(0.5 * turn), turn])
