"""Message periods and timeouts, shared by the driving node and `preflight`. No ROS imports."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

KEPT = 15
"""Number of steps in the median of the period, which tolerates a few lost messages."""
KNOWN = 3
"""Number of steps from which the period is known."""
PERIODS = 2.5
"""Automatic timeout, in periods."""
ROOM = 1.5
"""Minimum timeout, in periods: with a shorter one, normal jitter would stop the car."""


class Bounds(NamedTuple):
    """[s] Limits of an automatic timeout."""

    least: float
    most: float


BOUNDS = {
    "scan": Bounds(0.1, 0.5),
    "odom": Bounds(0.2, 0.3),
    "imu": Bounds(0.2, 0.3),
    "steering": Bounds(0.2, 0.3),
}
"""The minimum lets fast sources lose a few messages; the maximum limits driving blind to 1 m at 2 m/s."""


class Period:
    """Measures the period of one source by its stamps [s]."""

    def __init__(self) -> None:
        self.last: float | None = None
        self._steps: deque[float] = deque(maxlen=KEPT)
        self.seconds = 0.0

    def add(self, stamp: float) -> float:
        """Adds a message's stamp. Returns the step since the previous one; 0 if unknown."""
        step = 0.0 if self.last is None else max(stamp - self.last, 0.0)
        self.last = stamp
        if step > 0.0:
            self._steps.append(step)
            self.seconds = sorted(self._steps)[len(self._steps) // 2] if len(self._steps) >= KNOWN else 0.0
        return step

    def forget(self) -> None:
        """Resets, for example after the source was replaced."""
        self.last, self.seconds = None, 0.0
        self._steps.clear()


def timeout_of(given: float, period: float, bounds: Bounds) -> float:
    """Timeout [s] of a source. given: [s]; 0: computed from its period [s], which is 0 if unknown."""
    if given > 0.0:
        return given
    return min(max(PERIODS * period, bounds.least), bounds.most) if period > 0.0 else bounds.most


def rate_reason(source: str, period: float, timeout: float) -> str:
    """Why a source with this period [s] is too slow for its timeout [s]; empty if it is not."""
    if period <= 0.0:
        return f"too few messages of {source} yet to measure its rate"
    if period * ROOM <= timeout:
        return ""
    return f"{source} at {1.0 / period:.1f} Hz; with a timeout of {timeout:g} s it needs {ROOM / timeout:.1f} Hz"
