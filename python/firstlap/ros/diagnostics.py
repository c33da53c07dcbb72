"""How the driving node does: rates, latencies, status, step time, faults counted, once a second."""

from __future__ import annotations

import time
from collections import Counter, deque
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

KEPT = 400
"""Steps that the percentiles are of."""
LATE = 1.5
"""Scan periods between two stamps from which a scan counts as missed."""
MISSED = "missed scans"


def missed_between(dt: float, period: float) -> int:
    """How many scans are missing between two stamps that are dt [s] apart; none where the period is not known."""
    return round(dt / period) - 1 if period > 0.0 and dt > LATE * period else 0


class Health:
    """Collects, and publishes on /diagnostics."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.counts: Counter[str] = Counter()
        self._before: Counter[str] = Counter()
        self._steps: deque[tuple[float, float, float]] = deque(maxlen=KEPT)
        self._status = "none"
        self._published = 0.0

    def count(self, what: str) -> None:
        """One more."""
        self.counts[what] += 1

    def scan(self, stamp: float, dt: float, period: float) -> None:
        """A good scan; those that are missing since the one before are counted."""
        self.counts["scan"] += 1
        self.counts[MISSED] += missed_between(dt, period)

    def step(self, step: float, work: float, age: float, status: str) -> None:
        """One command: seconds in the driver, in the node, from the end of the scan to the command."""
        self.counts["drive"] += 1
        self.counts[f"status {status}"] += 1
        self._steps.append((step, work, age))
        self._status = status

    def values(self, elapsed: float) -> dict[str, str]:
        """What is told."""
        watchdog = self._node.watchdog
        told = {
            "state": "driving" if watchdog.armed else f"stopped: {watchdog.tripped or 'not armed'}",
            "driver": self._node.driving.setup.title,
            "status": self._status,
            MISSED: str(self.counts[MISSED]),
        }
        for what in ("scan", "odom", "drive"):
            told[f"{what} rate [Hz]"] = f"{(self.counts[what] - self._before[what]) / max(elapsed, 1e-3):.1f}"
        if self._steps:
            columns = np.array(self._steps)
            for column, name, scale in zip(
                columns.T, ("step [us]", "node [us]", "scan to drive [ms]"), (1e6, 1e6, 1e3), strict=True
            ):
                p50, p99 = np.percentile(scale * column, (50, 99))
                told[f"{name} p50"], told[f"{name} p99"] = f"{p50:.2f}", f"{p99:.2f}"
        for what, count in sorted({**self.counts, **watchdog.faults}.items()):
            if what not in ("scan", "odom", "drive"):
                told[what] = str(count)
        for source, reason in watchdog.rejected.items():
            told[f"last rejected {source}"] = reason
        return told

    def publish(self) -> None:
        """One DiagnosticArray."""
        now = time.monotonic()
        elapsed, self._published = now - self._published, now
        watchdog = self._node.watchdog
        stopped = self._node.active and not watchdog.armed
        status = DiagnosticStatus(
            level=DiagnosticStatus.ERROR if stopped else DiagnosticStatus.OK,
            name=f"{self._node.get_fully_qualified_name()}: driving".lstrip("/"),
            message=watchdog.tripped or self._status if self._node.active else "inactive",
            hardware_id="firstlap",
            values=[KeyValue(key=key, value=value) for key, value in self.values(elapsed).items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._before = Counter(self.counts)
        self._publisher.publish(message)
