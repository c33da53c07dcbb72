"""How the driving node does: rates, latencies, status, step time, faults counted, once a second."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

KEPT = 400
"""Steps that the percentiles are of."""
LATE = 1.5
"""Scan periods between two stamps from which a scan counts as missed."""
MISSED = "missed scans"
TIMES = {"step [us]": 1e6, "node [us]": 1e6, "scan to drive [ms]": 1e3}
"""Times of a step as they are told: name, parts of a second."""


def missed_between(dt: float, period: float) -> int:
    """How many scans are missing between two stamps that are dt [s] apart; none where the period is not known."""
    return round(dt / period) - 1 if period > 0.0 and dt > LATE * period else 0


def quantiles(values: Iterable[float], shares: Sequence[float]) -> list[float]:
    """Of at least one value, by its nearest rank. The driving thread asks for them: numpy would import half of itself
    for it while the car drives."""
    ranked = sorted(values)
    return [ranked[round(share * (len(ranked) - 1))] for share in shares]


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

    def scan(self, dt: float, period: float) -> None:
        """A good scan, dt [s] after the one before; those that are missing between them are counted."""
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
            "odometry": self._node.watch.summary,
        }
        for what in ("scan", "odom", "drive"):
            told[f"{what} rate [Hz]"] = f"{(self.counts[what] - self._before[what]) / max(elapsed, 1e-3):.1f}"
        for source, timeout in watchdog.timeouts.items():
            told[f"{source} timeout [s]"] = f"{timeout:.2f}"
        if self._steps:
            for column, (name, scale) in zip(zip(*self._steps, strict=True), TIMES.items(), strict=True):
                p50, p99 = quantiles(column, (0.5, 0.99))
                told[f"{name} p50"], told[f"{name} p99"] = f"{scale * p50:.2f}", f"{scale * p99:.2f}"
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
