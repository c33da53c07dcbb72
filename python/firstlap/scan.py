"""A scan as the drivers take it, and where the laser sits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt


class Scan(NamedTuple):
    """A scan as `step_core` takes it, in the frame of a laser that looks ahead. [m], [rad], [s]."""

    ranges: npt.NDArray[np.float32]
    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float


class Mount(NamedTuple):
    """Where the laser sits in base_link: x, y [m], yaw [rad], and whether it hangs upside down."""

    x: float
    y: float
    yaw: float
    upside_down: bool

    def turned(self, angle_min: float, angle_increment: float) -> tuple[float, float]:
        """Both [rad], of a scan's header, as a laser that looks ahead would have them."""
        hand = -1.0 if self.upside_down else 1.0
        return hand * angle_min + self.yaw, hand * angle_increment
