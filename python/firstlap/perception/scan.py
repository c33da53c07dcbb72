"""The header and the check of a scan, and the LiDAR's mounting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import CAR_FIELDS

USUAL_PERIOD = 1.0 / float(CAR_FIELDS.find("lidar.rate", "car").default)
"""[s] between two scans, where nothing tells: that of the default car's LiDAR."""
LASER = ("laser_x", "laser_y")
"""Fields of a car's geometry with the LiDAR's position."""


HEADER: tuple[str, ...] = tuple(column["name"] for column in _core.LaserScan.columns())
"""Fields of a scan's header, in order."""


class Mount(NamedTuple):
    """Mounting of the LiDAR in base_link: x, y [m], yaw [rad], and whether it is upside down."""

    x: float
    y: float
    yaw: float
    upside_down: bool

    def turned(self, angle_min: float, angle_increment: float) -> tuple[float, float]:
        """angle_min and angle_increment [rad] of a scan's header, for a LiDAR that points forward."""
        hand = -1.0 if self.upside_down else 1.0
        return hand * angle_min + self.yaw, hand * angle_increment


class Judgment(NamedTuple):
    """The core's check of a scan.

    fault: its name, 'none' for a valid scan. reason: what is wrong and what would be right; '' for a valid scan.
    remarks: on a valid scan.
    """

    fault: str
    reason: str
    remarks: tuple[str, ...]


def judge(scan: _core.LaserScan, period: float | None = None, angle_max: float | None = None) -> Judgment:
    """Checks whether a scan is valid, with the check that all drivers use.

    period: [s] between scans, to check time_increment. angle_max: [rad] of the last beam as stated in its
    message, rotated like angle_min.
    """
    last = math.nan if angle_max is None else angle_max
    fault, reason, remarks = _core.judge_scan(scan, period or 0.0, last)
    return Judgment(fault, reason, tuple(remarks))


def sweep_time(time_increment: float, beams: int, period: float = 0.0) -> float:
    """[s] from a scan's first beam to its last; 0 if time_increment [s] is implausible.

    period: [s] between scans, the upper limit of a sweep; 0: unknown.
    """
    return _core.usable_sweep_time(time_increment, beams, period)


def ray_ends(laser: tuple[float, float], angles: npt.ArrayLike, ranges: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(N, 2) end points of rays in base_link [m]. laser: its x, y in base_link; angles [rad], ranges [m] (N,)."""
    angle, reach = np.asarray(angles, dtype=np.float64), np.asarray(ranges, dtype=np.float64)
    return np.column_stack([laser[0] + reach * np.cos(angle), laser[1] + reach * np.sin(angle)])


def laser_of(geometry: Mapping[str, object]) -> tuple[float, float]:
    """x, y [m] of the LiDAR in base_link, from a car's geometry."""
    x, y = (float(geometry[name]) for name in LASER)  # type: ignore[arg-type]
    return x, y


def set_laser(car: _core.Car, x: float, y: float) -> None:
    """Sets the position [m] of the car's LiDAR in base_link. Raises ValueError if it is out of range."""
    for name, value in zip(LASER, (x, y), strict=True):
        car.set("geometry", name, value)
