"""From decoded LaserScan messages to arrays: what fits is used, the rest is counted."""

from __future__ import annotations

from collections import Counter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Nanoseconds = npt.NDArray[np.int64]


class Scans(NamedTuple):
    """ranges: N float32 arrays; headers (N, 5) as messages have them; stamped, logged (N,) [ns]; frame: the laser's."""

    ranges: list[npt.NDArray[np.float32]]
    headers: Floats
    stamped: Nanoseconds
    logged: Nanoseconds
    remarks: list[str]
    frame: str = ""


def collect(messages: list[tuple[int, Any]]) -> Scans:
    """Scans of (time of logging [ns], LaserScan), in their order."""
    ranges: list[npt.NDArray[np.float32]] = []
    headers: list[tuple[float, float, float, float, float]] = []
    stamped: list[int] = []
    logged: list[int] = []
    refused: Counter[str] = Counter()
    for time, scan in messages:
        why = _wrong(scan)
        if why:
            refused[why] += 1
            continue
        ranges.append(np.ascontiguousarray(scan.ranges, dtype=np.float32))
        headers.append((scan.angle_min, scan.angle_increment, scan.time_increment, scan.range_min, scan.range_max))
        stamped.append(nanoseconds(scan.header.stamp))
        logged.append(time)
    remarks = [f"{count} scans left out: {why}" for why, count in refused.items()]
    sizes = Counter(len(one) for one in ranges)
    if len(sizes) > 1:
        listed = ", ".join(f"{count} of {size} beams" for size, count in sizes.most_common(4))
        remarks.append(f"the scans change size: {listed}; each is read by its own header")
    return Scans(
        ranges,
        np.array(headers, dtype=np.float64).reshape(-1, 5),
        np.array(stamped, dtype=np.int64),
        np.array(logged, dtype=np.int64),
        remarks,
        str(messages[0][1].header.frame_id) if messages else "",
    )


def nanoseconds(stamp: Any) -> int:
    """builtin_interfaces/Time as one number."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _wrong(scan: Any) -> str:
    count = len(scan.ranges)
    numbers = (scan.angle_min, scan.angle_increment, scan.time_increment, scan.range_min)
    if count == 0:
        return "no beams"
    if not np.all(np.isfinite(numbers)) or scan.angle_increment == 0.0 or not scan.range_max > scan.range_min:
        return "a header that makes no sense"
    spanned = scan.angle_min + scan.angle_increment * (count - 1)
    # Some drivers count one beam more or less than there are.
    if abs(spanned - scan.angle_max) > 2.5 * abs(scan.angle_increment):
        return "as many beams as do not fit their header's angles"
    return ""
