"""The car's pose from messages: odometry, a localizer's transform map -> odom, or a simulator's ground truth."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.config.car_file import Car
from firstlap.perception.frames import Frames
from firstlap.pitwall.frame import Pose
from firstlap.pitwall.laps import LapBook
from firstlap.pitwall.shapes import points_in, returns_in
from firstlap.ros.conversions import seconds, yaw_of

MAP = "map"
KEPT = 200
"""Number of poses kept, to find the one of a trace's stamp."""
TRUTH_LASTS = 1.0
"""[s] Without ground truth for this time, odometry is used again."""


class Places:
    """Poses in one frame: the map frame if it is known, else the odometry frame. Also times laps."""

    def __init__(self) -> None:
        self.frames = Frames()
        self.book = LapBook()
        self.in_map = False
        self.speed = self.yaw_rate = 0.0
        self._poses: deque[tuple[float, Pose]] = deque(maxlen=KEPT)
        self._truth_at = -math.inf

    def on_odometry(self, message: Any) -> None:
        """Takes the car's nav_msgs/Odometry."""
        twist = message.twist.twist
        if not all(map(math.isfinite, (twist.linear.x, twist.angular.z))):
            return
        self.speed, self.yaw_rate = twist.linear.x, twist.angular.z
        if time.monotonic() - self._truth_at < TRUTH_LASTS:
            return
        to_map = self.frames.find(MAP, message.header.frame_id)
        self._add(message, to_map, to_map is not None)

    def on_ground_truth(self, message: Any) -> None:
        """Takes a simulator's ground truth, a nav_msgs/Odometry in the map frame."""
        if message.header.frame_id.lstrip("/") == MAP:
            self._truth_at = time.monotonic()
            self._add(message, None, True)

    def _add(self, message: Any, to_map: npt.NDArray[np.float64] | None, in_map: bool) -> None:
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = (place.x, place.y, yaw_of(turn))
        if to_map is not None:
            x, y, _, _ = to_map @ (pose[0], pose[1], 0.0, 1.0)
            pose = (float(x), float(y), pose[2] + math.atan2(to_map[1, 0], to_map[0, 0]))
        stamp = seconds(message.header.stamp)
        if not all(map(math.isfinite, (*pose, stamp))):
            return
        if in_map != self.in_map:  # lines in another frame are meaningless in this one
            self.in_map = in_map
            self.book = LapBook()
            self._poses.clear()
        if self._poses and stamp <= self._poses[-1][0]:
            self._poses.clear()
        self._poses.append((stamp, pose))
        self.book.add(stamp, pose, message.twist.twist.linear.x)

    def at(self, stamp: float) -> Pose | None:
        """The pose at a time [s], interpolated, or the nearest one; None without poses."""
        after: tuple[float, Pose] | None = None
        for one in reversed(self._poses):
            if one[0] <= stamp:
                return one[1] if after is None else _between(one, after, stamp)
            after = one
        return None if after is None else after[1]

    def newest(self) -> tuple[float, Pose | None]:
        """Stamp [s] and pose of the newest odometry."""
        return self._poses[-1] if self._poses else (0.0, None)


def _between(before: tuple[float, Pose], after: tuple[float, Pose], stamp: float) -> Pose:
    share = (stamp - before[0]) / (after[0] - before[0])
    (x, y, yaw), (x2, y2, yaw2) = before[1], after[1]
    turn = math.remainder(yaw2 - yaw, 2.0 * math.pi)
    return x + share * (x2 - x), y + share * (y2 - y), yaw + share * turn


def geometry(car: Car, name: str) -> float:
    """A value of the car's section `geometry`."""
    return float(car.core.get("geometry", name))  # type: ignore[arg-type]


def clearance(points: npt.NDArray[np.float64], car: Car) -> float | None:
    """Distance [m] from the car's body to the nearest finite point (N, 2) in base_link; None if there is none."""
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return None
    length, width, overhang = (geometry(car, name) for name in ("length", "width", "rear_overhang"))
    middle = 0.5 * length - overhang
    aside = np.maximum(np.abs(points - (middle, 0.0)) - (0.5 * length, 0.5 * width), 0.0)
    return float(np.sqrt((aside * aside).sum(axis=1).min()))


def points_of(trace: dict[str, Any], laser: tuple[float, float]) -> npt.NDArray[np.float64]:
    """(N, 2) returns in base_link [m] of the trace of any driver."""
    return np.vstack([points_in(trace, "points"), returns_in(trace, laser)])
