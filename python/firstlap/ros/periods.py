"""How often a source comes, and how long it may be silent: for the driving node and `preflight` alike. Plain Python."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

KEPT = 15
"""Steps between stamps that the period is the median of: a few lost messages do not change it."""
KNOWN = 3
"""Steps from which the period counts as measured."""
PERIODS = 2.5
"""Periods that a source may be silent, where nobody says another timeout."""
ROOM = 1.5
"""Periods that any timeout must have room for: with less, the jitter of a sound source stops the car."""


class Bounds(NamedTuple):
    """[s] between which an automatic timeout lies."""

    least: float
    most: float


BOUNDS = {
    "scan": Bounds(0.1, 0.5),
    "odom": Bounds(0.2, 0.3),
    "imu": Bounds(0.2, 0.3),
    "steering": Bounds(0.2, 0.3),
}
"""What is faster than the least may still lose a few messages; the most is 1 m of driving blind at 2 m/s."""


class Period:
    """The period of one source, measured by its own stamps [s]."""

    def __init__(self) -> None:
        self.last: float | None = None
        self._steps: deque[float] = deque(maxlen=KEPT)
        self.seconds = 0.0

    def hear(self, stamp: float) -> float:
        """A message's stamp. The step since the one before; 0 where that is not known."""
        step = 0.0 if self.last is None else max(stamp - self.last, 0.0)
        self.last = stamp
        if step > 0.0:
            self._steps.append(step)
            self.seconds = sorted(self._steps)[len(self._steps) // 2] if len(self._steps) >= KNOWN else 0.0
        return step

    def forget(self) -> None:
        """The source may be another one from now on."""
        self.last, self.seconds = None, 0.0
        self._steps.clear()


def timeout_of(given: float, period: float, bounds: Bounds) -> float:
    """[s] that a source may be silent. given: [s] as somebody wants it; 0: by its period [s], 0 where not known."""
    if given > 0.0:
        return given
    return min(max(PERIODS * period, bounds.least), bounds.most) if period > 0.0 else bounds.most


def rate_reason(source: str, period: float, timeout: float) -> str:
    """Why a source with this period [s] comes too seldom for its timeout [s]; empty where it does not."""
    if period <= 0.0:
        return f"too little of {source} yet to know its rate"
    if period * ROOM <= timeout:
        return ""
    return f"{source} at {1.0 / period:.1f} Hz; with a timeout of {timeout:g} s it needs {ROOM / timeout:.1f} Hz"
