"""Laps with their lines, while they are driven."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from firstlap.pitwall.frame import DrivenLap

KEPT_LINES = 30
"""So many newest laps keep their lines, and the best one does."""
LONGEST_LINE = 20_000
"""Points of a line; a longer one keeps every second of them."""
STEP = 0.01
"""[m] between two points at least."""


class DrivenLine:
    """The line of the lap that is being driven: a point per scan, none while the car stands."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float, float]] = []

    def add(self, x: float, y: float, speed: float) -> None:
        """[m, m/s] in the map frame."""
        if self.points and abs(x - self.points[-1][0]) + abs(y - self.points[-1][1]) < STEP:
            return
        self.points.append((x, y, speed))
        if len(self.points) > LONGEST_LINE:
            del self.points[1::2]

    def take(self, number: int, time: float, clearance: float | None, standing: bool) -> DrivenLap:
        """The lap that ends here. The next one begins at its last point."""
        rows = np.array(self.points or [(0.0, 0.0, 0.0)])
        self.points = self.points[-1:]
        return DrivenLap(number, time, rows[:, :2].copy(), rows[:, 2].copy(), clearance, standing)

    def clear(self) -> None:
        """The car was taken away."""
        self.points = []


def with_lap(laps: tuple[DrivenLap, ...], lap: DrivenLap) -> tuple[DrivenLap, ...]:
    """The laps with one more; old ones that are not the best lose their lines, so that memory stays bounded."""
    laps = (*laps, lap)
    old = len(laps) - 1 - KEPT_LINES
    if old < 0:
        return laps
    best = min(range(len(laps)), key=lambda i: laps[i].time)
    return tuple(_bare(one) if i <= old and i != best and len(one.line) else one for i, one in enumerate(laps))


def _bare(lap: DrivenLap) -> DrivenLap:
    return replace(lap, line=np.zeros((0, 2)), speed=np.zeros(0))
