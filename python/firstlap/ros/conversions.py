"""Conversions between messages and numbers. Nothing here needs a node; most messages are duck-typed."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.perception.scan import Judgment, Mount, judge, sweep_time


def seconds(stamp: Any) -> float:
    """builtin_interfaces/Time as seconds."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def nanoseconds(time: float) -> int:
    """Converts seconds to nanoseconds as in a stamp."""
    whole = math.floor(time)
    return whole * 1_000_000_000 + min(round((time - whole) * 1e9), 999_999_999)


def set_stamp(stamp: Any, time: float) -> None:
    """Sets a builtin_interfaces/Time from seconds."""
    stamp.sec, stamp.nanosec = divmod(nanoseconds(time), 1_000_000_000)


def sweep_of(message: Any, period: float) -> float:
    """Sweep time [s] of a LaserScan, see `firstlap.perception.scan.sweep_time`."""
    return sweep_time(message.time_increment, len(message.ranges), period)


def to_scan(message: Any, mount: Mount) -> _core.LaserScan:
    """Converts a LaserScan, with its angles as mounted."""
    ranges = np.frombuffer(message.ranges, dtype=np.float32)
    first, step = mount.turned(message.angle_min, message.angle_increment)
    return _core.LaserScan(ranges, first, step, message.time_increment, message.range_min, message.range_max)


def judged(message: Any, mount: Mount, period: float) -> tuple[_core.LaserScan, Judgment]:
    """Converts a LaserScan, with its angles as mounted, and checks it. period: scan period [s]; 0: unknown."""
    scan = to_scan(message, mount)
    last, _ = mount.turned(message.angle_max, message.angle_increment)
    return scan, judge(scan, period, last)


def float_array(values: npt.NDArray[np.float32]) -> array.array[float]:
    """Converts to an array that rclpy takes without checking each item."""
    result = array.array("f")
    result.frombytes(np.ascontiguousarray(values, dtype=np.float32).tobytes())
    return result


def quaternion_of(yaw: float) -> tuple[float, float]:
    """Quaternion z and w of a rotation about z by `yaw` [rad]."""
    return math.sin(0.5 * yaw), math.cos(0.5 * yaw)


def yaw_of(q: Any) -> float:
    """Yaw [rad] of a quaternion."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
