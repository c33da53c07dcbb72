"""A scan as the drivers take it, what is right and wrong with it, and where the laser sits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core


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


class Judgement(NamedTuple):
    """What the core says of a scan.

    fault: its name, 'none' where the scan may be used. reason: what is wrong and what would be right, for people; ''
    where the scan may be used. remarks: what is worth knowing of a scan that may.
    """

    fault: str
    reason: str
    remarks: tuple[str, ...]


def judge(scan: Scan, period: float | None = None, angle_max: float | None = None) -> Judgement:
    """Whether a scan may be used, as every driver sees it.

    period: [s] between scans, by which time_increment is judged. angle_max: [rad] of the last beam as its message
    states it, turned like angle_min.
    """
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float32)
    last = math.nan if angle_max is None else angle_max
    fault, reason, remarks = _core.judge_scan(ranges, *scan[1:], period or 0.0, last)
    return Judgement(fault, reason, tuple(remarks))


def returns(scan: Scan) -> npt.NDArray[np.bool_]:
    """(N,) which beams are returns; the others saw nothing, however that is spelled (REP 117)."""
    ranges = np.ascontiguousarray(scan.ranges, dtype=np.float32)
    return _core.scan_returns(ranges, scan.range_min, scan.range_max).astype(bool)


def ray_ends(laser: tuple[float, float], angles: npt.ArrayLike, ranges: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(N, 2) where rays from the laser end, in base_link [m]. laser: x, y there; angles [rad], ranges [m] (N,)."""
    angle, reach = np.asarray(angles, dtype=np.float64), np.asarray(ranges, dtype=np.float64)
    return np.column_stack([laser[0] + reach * np.cos(angle), laser[1] + reach * np.sin(angle)])


def laser_of(geometry: Mapping[str, object]) -> tuple[float, float]:
    """x, y [m] of the laser in base_link, of a car's geometry."""
    return float(geometry["laser_x"]), float(geometry["laser_y"])  # type: ignore[arg-type]
