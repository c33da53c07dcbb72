"""What a viewer is shown of one moment, and of the place around it."""

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
    """A complete lap: its number from 1, time [s], smallest clearance [m] where known, and line (N, 2) with its
    speeds (N,) [m/s] in the map frame. standing: it began at rest. setup: what drove its end, where that is known.
    mixed: something else drove its begin."""

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
    """One step of a driver, ready to be shown. SI units; immutable once it is handed over; pickles.

    number: counts the steps of its source; a new one is a new picture. time: [s] of the source's clock. pose: None
    where the car's place is not known: then everything is shown around the car. speed, yaw_rate, steering_angle:
    measured. trace: of the driver, in base_link (cpp/firstlap/drivers/trace.hpp);
    empty before its first step. step_us: the step's own time. way, offset:
    [m] along and left of the centerline, where known. clearance: [m] smallest so far in this lap, where known.
    began: [s] of the source's clock at which the running lap began, where the source knows it.
    laps: complete ones, oldest first. before: the trace of the loaded setup over the same scan, where another one is
    tried on a recording. going: whether the car may move. said: why it does not, or what just happened.
    sent: speed [m/s] and steering angle [rad] that the car is sent instead of the step's result; None where it is that.
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
    way: float | None = None
    offset: float | None = None
    clearance: float | None = None
    began: float | None = None
    laps: tuple[DrivenLap, ...] = ()
    before: Mapping[str, Any] | None = None
    going: bool = True
    said: str = ""
    sent: tuple[float, float] | None = None


@dataclass(frozen=True)
class Scenery:
    """What stands still: walls as polylines (N, 2) in the map frame with whether the LiDAR sees each, and the
    centerline (N, 2); all empty where the track is not known."""

    walls: tuple[Points, ...] = ()
    visible: tuple[bool, ...] = ()
    centerline: Points = field(default_factory=lambda: np.zeros((0, 2)))

    def bounds(self) -> tuple[Points, Points] | None:
        """Lower left and upper right corner [m]; None where nothing is known."""
        if not self.walls:
            return None
        points = np.vstack(self.walls)
        return points.min(axis=0), points.max(axis=0)
