"""Whether a clock that can be stopped goes on. Plain Python: no ROS, no clock of its own."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class ClockWatch:
    """limit: [s] of the steady clock in which the other one must move."""

    limit: float
    _seen: float | None = None
    _moved: float | None = None

    def update(self, now: float, steady: float) -> None:
        """Call often. now: the clock's time [s]. steady: of a clock that cannot be stopped [s]."""
        if now != self._seen:
            self._seen, self._moved = now, steady

    def reason(self, steady: float) -> str:
        """Why the clock cannot be trusted; empty if it can."""
        stall = 0.0 if self._moved is None else steady - self._moved
        return f"/clock has not advanced for {stall:.2f} s" if stall > self.limit else ""
