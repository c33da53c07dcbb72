"""The data of one displayed frame and its surroundings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.config.setup_file import Setup

Pose = tuple[float, float, float]
"""x, y [m], yaw [rad] of base_link in the map frame."""
Points = npt.NDArray[np.float64]
"""(N, 2) [m]"""


@dataclass(frozen=True)
class DrivenLap:
    """A complete lap: number from 1, time [s], smallest clearance [m] if known, and driven line (N, 2) [m] in the map
    frame with its speeds (N,) [m/s]. standing: a standing-start lap. setup: at the end of the lap, if known. mixed: the
    setup changed during the lap."""

    number: int
    time: float
    line: Points
    speed: npt.NDArray[np.float64]
    clearance: float | None = None
    standing: bool = False
    setup: Setup | None = None
    mixed: bool = False


@dataclass(frozen=True)
class Frame:
    """One step of a driver, ready for display. SI units; immutable; picklable.

    number: changes with every new frame of the source. time: [s] of the source's clock. pose: None if unknown; then the
    car is drawn at the origin. speed, yaw_rate, steering_angle: measured. trace: of the driver, in base_link
    (cpp/firstlap/drivers/trace.hpp); empty before its first step. step_us: compute time of the step [us]. distance,
    offset: [m] along and left of the centerline, if known. clearance: [m] smallest one in this lap so far, if known.
    lap_start: [s] start time of the current lap, if known. laps: complete laps, oldest first. before: trace of the
    loaded setup for the same scan, if a changed one is tried on a recording. may_drive: whether the car may move.
    message: why it may not, or the latest event. sent: speed [m/s] and steering angle [rad] that are sent to the car
    instead of the step's result; None if the result is sent.
    """

    number: int
    time: float
    pose: Pose | None
    speed: float
    yaw_rate: float
    steering_angle: float
    driver: str
    trace: Mapping[str, Any]
    step_us: float
    distance: float | None = None
    offset: float | None = None
    clearance: float | None = None
    lap_start: float | None = None
    laps: tuple[DrivenLap, ...] = ()
    before: Mapping[str, Any] | None = None
    may_drive: bool = True
    message: str = ""
    sent: tuple[float, float] | None = None


@dataclass(frozen=True)
class Scenery:
    """Static surroundings: walls as polylines (N, 2) [m] in the map frame, whether the LiDAR can see each wall, and the
    centerline (N, 2) [m]. All are empty if the track is unknown."""

    walls: tuple[Points, ...] = ()
    visible: tuple[bool, ...] = ()
    centerline: Points = field(default_factory=lambda: np.zeros((0, 2)))

    def bounds(self) -> tuple[Points, Points] | None:
        """Lower left and upper right corner [m]; None without walls."""
        if not self.walls:
            return None
        points = np.vstack(self.walls)
        return points.min(axis=0), points.max(axis=0)
