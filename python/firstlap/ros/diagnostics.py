"""Diagnostics of the driving node, once a second: rates, latencies, status, step times and fault counts."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

KEPT = 400
"""Number of steps in the percentiles."""
LATE = 1.5
"""A gap of more scan periods than this counts as missed scans."""
MISSED = "missed scans"
TIMES = {"step [us]": 1e6, "node [us]": 1e6, "scan to drive [ms]": 1e3}
"""Times of a step: key in the message -> scale from seconds."""


def missed_between(dt: float, period: float) -> int:
    """Number of scans missing between two stamps `dt` [s] apart; 0 if the period [s] is unknown (0)."""
    return round(dt / period) - 1 if period > 0.0 and dt > LATE * period else 0


def quantiles(values: Iterable[float], shares: Sequence[float]) -> list[float]:
    """Quantiles by the nearest rank, of at least one value. Without numpy, whose lazy imports would delay the driving
    thread."""
    ranked = sorted(values)
    return [ranked[round(share * (len(ranked) - 1))] for share in shares]


class Health:
    """Collects diagnostics and publishes them on /diagnostics."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.counts: Counter[str] = Counter()
        self._before: Counter[str] = Counter()
        self._steps: deque[tuple[float, float, float]] = deque(maxlen=KEPT)
        self._status = "none"
        self._published = 0.0

    def count(self, what: str) -> None:
        """Increments a counter."""
        self.counts[what] += 1

    def scan(self, dt: float, period: float) -> None:
        """Counts a valid scan, `dt` [s] after the previous one, and the scans missing between them."""
        self.counts["scan"] += 1
        self.counts[MISSED] += missed_between(dt, period)

    def step(self, step: float, work: float, age: float, status: str) -> None:
        """Adds a command: time in the driver, time in the node, and time since the end of the scan [s]."""
        self.counts["drive"] += 1
        self.counts[f"status {status}"] += 1
        self._steps.append((step, work, age))
        self._status = status

    def values(self, elapsed: float) -> dict[str, str]:
        """The key-value pairs of the message."""
        watchdog = self._node.watchdog
        values = {
            "state": "driving" if watchdog.armed else f"stopped: {watchdog.tripped or 'not armed'}",
            "driver": self._node.driving.setup.title,
            "status": self._status,
            MISSED: str(self.counts[MISSED]),
            "odometry": self._node.watch.summary,
        }
        for what in ("scan", "odom", "drive"):
            values[f"{what} rate [Hz]"] = f"{(self.counts[what] - self._before[what]) / max(elapsed, 1e-3):.1f}"
        for source, timeout in watchdog.timeouts.items():
            values[f"{source} timeout [s]"] = f"{timeout:.2f}"
        if self._steps:
            for column, (name, scale) in zip(zip(*self._steps, strict=True), TIMES.items(), strict=True):
                p50, p99 = quantiles(column, (0.5, 0.99))
                values[f"{name} p50"], values[f"{name} p99"] = f"{scale * p50:.2f}", f"{scale * p99:.2f}"
        for what, count in sorted({**self.counts, **watchdog.faults}.items()):
            if what not in ("scan", "odom", "drive"):
                values[what] = str(count)
        for source, reason in watchdog.rejected.items():
            values[f"last rejected {source}"] = reason
        return values

    def publish(self) -> None:
        """Publishes one DiagnosticArray."""
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
