"""Between messages and numbers. No function here needs a node; messages are duck-typed where that is enough."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.ros.periods import BOUNDS
from firstlap.scan import Mount, Scan

NAN_SHARE = 0.5
"""More NaN than this in a scan, and it is no measurement."""


def seconds(stamp: Any) -> float:
    """builtin_interfaces/Time as seconds."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def set_stamp(stamp: Any, time: float) -> None:
    """Seconds into a builtin_interfaces/Time."""
    whole = math.floor(time)
    stamp.sec, stamp.nanosec = int(whole), min(round((time - whole) * 1e9), 999_999_999)


def scan_reason(message: Any) -> str:
    """Why a LaserScan must not be used, by its own header; empty when it may."""
    count = len(message.ranges)
    if count < 2:
        return f"{count} beams"
    header = (message.angle_min, message.angle_max, message.angle_increment, message.time_increment)
    if not all(math.isfinite(value) for value in header) or message.angle_increment == 0.0:
        return "its header is not finite"
    span = message.angle_min + message.angle_increment * (count - 1)
    if abs(message.angle_max - span) > 2.0 * abs(message.angle_increment):
        return f"{count} beams do not fit its angles"
    ranges = np.frombuffer(message.ranges, dtype=np.float32)
    lost = np.count_nonzero(np.isnan(ranges))
    return f"{100.0 * lost / count:.0f} % of it is NaN" if lost > NAN_SHARE * count else ""


def sweep_of(message: Any) -> float:
    """[s] from the first beam of a LaserScan to its last, no longer than a scan that can be driven by."""
    return min(abs(message.time_increment) * len(message.ranges), BOUNDS["scan"].most)


def to_scan(message: Any, mount: Mount) -> Scan:
    """A LaserScan whose header makes sense, turned as the laser is mounted."""
    ranges = np.frombuffer(message.ranges, dtype=np.float32)
    first, step = mount.turned(message.angle_min, message.angle_increment)
    return Scan(ranges, first, step, message.time_increment, message.range_min, message.range_max)


def float_array(values: npt.NDArray[np.float32]) -> array.array[float]:
    """A sequence that rclpy takes without looking at each number."""
    result = array.array("f")
    result.frombytes(np.ascontiguousarray(values, dtype=np.float32).tobytes())
    return result


def quaternion_of(yaw: float) -> tuple[float, float]:
    """z and w of a turn about z."""
    return math.sin(0.5 * yaw), math.cos(0.5 * yaw)


def yaw_of(q: Any) -> float:
    """Yaw [rad] of a quaternion."""
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
