"""A scan as the drivers take it, what is right and wrong with it, and where the laser sits."""

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
"""Of a car's geometry: where the laser sits."""


class Scan(NamedTuple):
    """A scan as `step_core` takes it, in the frame of a laser that looks ahead. [m], [rad], [s].

    The seam between its first and last beam may lie anywhere, and it may turn either way.
    """

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


class Judgment(NamedTuple):
    """What the core says of a scan.

    fault: its name, 'none' where the scan may be used. reason: what is wrong and what would be right, for people; ''
    where the scan may be used. remarks: what is worth knowing of a scan that may.
    """

    fault: str
    reason: str
    remarks: tuple[str, ...]


def judge(scan: Scan, period: float | None = None, angle_max: float | None = None) -> Judgment:
    """Whether a scan may be used, as every driver sees it.

    period: [s] between scans, by which time_increment is judged. angle_max: [rad] of the last beam as its message
    states it, turned like angle_min.
    """
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float32)
    last = math.nan if angle_max is None else angle_max
    fault, reason, remarks = _core.judge_scan(ranges, *scan[1:], period or 0.0, last)
    return Judgment(fault, reason, tuple(remarks))


def returns(scan: Scan) -> npt.NDArray[np.bool_]:
    """(N,) which beams are returns; the others saw nothing, however that is spelled (REP 117)."""
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float32)
    return _core.scan_returns(ranges, scan.range_min, scan.range_max).astype(bool)


def sweep_time(time_increment: float, beams: int, period: float = 0.0) -> float:
    """[s] from a scan's first beam to its last; 0 where time_increment [s] cannot be true.

    period: [s] between scans, which a sweep cannot be longer than; 0: not known.
    """
    return _core.usable_sweep_time(time_increment, beams, period)


def ray_ends(laser: tuple[float, float], angles: npt.ArrayLike, ranges: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(N, 2) where rays from the laser end, in base_link [m]. laser: x, y there; angles [rad], ranges [m] (N,)."""
    angle, reach = np.asarray(angles, dtype=np.float64), np.asarray(ranges, dtype=np.float64)
    return np.column_stack([laser[0] + reach * np.cos(angle), laser[1] + reach * np.sin(angle)])


def laser_of(geometry: Mapping[str, object]) -> tuple[float, float]:
    """x, y [m] of the laser in base_link, of a car's geometry."""
    x, y = (float(geometry[name]) for name in LASER)  # type: ignore[arg-type]
    return x, y


def set_laser(car: _core.Car, x: float, y: float) -> None:
    """Puts the car's laser there [m], in base_link. Raises ValueError outside of its range."""
    for name, value in zip(LASER, (x, y), strict=True):
        car.set("geometry", name, value)
