"""Converts LaserScan messages to arrays; scans that fail the core's check are counted and dropped."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.perception.scan import HEADER, Judgment, Mount, judge
from firstlap.recordings.clock import usual_period

Floats = npt.NDArray[np.float64]
Nanoseconds = npt.NDArray[np.int64]

USABLE = "none"
BLIND = "blind_ahead"
"""The fault that a different mounting fixes."""
OF_RANGES = ("no_returns", "nothing_in_reach")
"""Faults of a scan's ranges, not of its header: such scans are kept, and the planner holds as on the car."""
NUMBER = re.compile(r"[\d.-]+")
"""Numbers in a remark: remarks that differ only in numbers are of the same kind."""
WORTH_SAYING = 0.1
"""Share of the scans above which a remark of the check is reported."""


class Scans(NamedTuple):
    """ranges: N float32 arrays; headers (N, 5) as in the messages; stamped, logged (N,) [ns].

    usable: number of valid scans. fault, reason: the most frequent fault of the others; empty if there are none.
    """

    ranges: list[npt.NDArray[np.float32]]
    headers: Floats
    stamped: Nanoseconds
    logged: Nanoseconds
    usable: int
    fault: str
    reason: str
    remarks: list[str]


class Findings:
    """Counts the results of the scan check."""

    def __init__(self) -> None:
        self.usable = self._total = 0
        self._faults: dict[str, list[str]] = {}
        self._remarks: dict[str, list[str]] = {}

    def keeps(self, judgment: Judgment) -> bool:
        """Counts the result; returns whether the scan is kept."""
        self._total += 1
        if judgment.fault == USABLE:
            self.usable += 1
        else:
            self._faults.setdefault(judgment.fault, []).append(judgment.reason)
        for remark in judgment.remarks:
            self._remarks.setdefault(_without_numbers(remark), []).append(remark)
        return judgment.fault == USABLE or judgment.fault in OF_RANGES

    @property
    def fault(self) -> str:
        """The most frequent fault; empty if there is none."""
        return max(self._faults, key=lambda fault: len(self._faults[fault])) if self._faults else ""

    @property
    def reason(self) -> str:
        """The reason of the most frequent fault, from its first scan."""
        return self._faults[self.fault][0] if self._faults else ""

    def remarks(self) -> list[str]:
        """One line per kind, from its first scan."""
        said = []
        for fault, reasons in self._faults.items():
            what = "invalid scans" if fault in OF_RANGES else "scans left out"
            said.append(f"{len(reasons)} {what}: {reasons[0]}")
        often = [found for found in self._remarks.values() if len(found) >= WORTH_SAYING * self._total]
        return [*said, *(f"{found[0]} (in {len(found)} of {self._total} scans)" for found in often)]


def _without_numbers(text: str) -> str:
    return NUMBER.sub("#", text)


def collect(messages: list[tuple[int, Any]], mount: Mount | None) -> Scans:
    """Collects the scans from (log time [ns], LaserScan), in order. mount: the LiDAR's mounting, if known."""
    period = usual_period(np.array([nanoseconds(scan.header.stamp) for _, scan in messages], dtype=np.int64)) / 1e9
    findings, kept = Findings(), list[tuple[int, Any]]()
    for time, message in messages:
        scan, angle_max = _mounted(message, mount)
        if findings.keeps(judge(scan, period, angle_max)):
            kept.append((time, message))
    ranges = [np.ascontiguousarray(scan.ranges, dtype=np.float32) for _, scan in kept]
    headers = [[getattr(scan, name) for name in HEADER] for _, scan in kept]
    return Scans(
        ranges,
        np.array(headers, dtype=np.float64).reshape(-1, len(HEADER)),
        np.array([nanoseconds(scan.header.stamp) for _, scan in kept], dtype=np.int64),
        np.array([time for time, _ in kept], dtype=np.int64),
        findings.usable,
        findings.fault,
        findings.reason,
        [*findings.remarks(), *_sizes(ranges)],
    )


def nanoseconds(stamp: Any) -> int:
    """builtin_interfaces/Time in nanoseconds."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _mounted(message: Any, mount: Mount | None) -> tuple[_core.LaserScan, float]:
    """The scan for a LiDAR that points forward, and its angle_max."""
    header, last = {name: getattr(message, name) for name in HEADER}, message.angle_max
    if mount is not None:
        last, _ = mount.turned(last, message.angle_increment)
        header["angle_min"], header["angle_increment"] = mount.turned(message.angle_min, message.angle_increment)
    return _core.LaserScan(np.ascontiguousarray(message.ranges, dtype=np.float32), **header), last


def _sizes(ranges: list[npt.NDArray[np.float32]]) -> list[str]:
    sizes = Counter(len(one) for one in ranges)
    if len(sizes) < 2:
        return []
    listed = ", ".join(f"{count} of {size} beams" for size, count in sizes.most_common(4))
    return [f"the number of beams changes: {listed}; each scan is read with its own header"]
