"""Recording of the driven lines of laps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from firstlap.pitwall.frame import DrivenLap

KEPT_LINES = 30
"""Number of newest laps that keep their lines; the best lap keeps its line too."""
LONGEST_LINE = 20_000
"""Maximum number of points of a line; a longer one drops every second point."""
STEP = 0.01
"""[m] Minimum spacing of points."""


class DrivenLine:
    """The driven line of the current lap: one point per scan, none while the car is stopped."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float, float]] = []

    def add(self, x: float, y: float, speed: float) -> None:
        """Adds a position [m] in the map frame, and the speed [m/s]."""
        if self.points and abs(x - self.points[-1][0]) + abs(y - self.points[-1][1]) < STEP:
            return
        self.points.append((x, y, speed))
        if len(self.points) > LONGEST_LINE:
            del self.points[1::2]

    def finish(self, number: int, time: float, clearance: float | None, standing: bool) -> DrivenLap:
        """The finished lap. The next one starts at its last point."""
        rows = np.array(self.points or [(0.0, 0.0, 0.0)])
        self.points = self.points[-1:]
        return DrivenLap(number, time, rows[:, :2].copy(), rows[:, 2].copy(), clearance, standing)

    def clear(self) -> None:
        """Discards the line, after the car was moved."""
        self.points = []


def with_lap(laps: tuple[DrivenLap, ...], lap: DrivenLap) -> tuple[DrivenLap, ...]:
    """Appends a lap. Old laps except the best one lose their lines, to bound the memory."""
    laps = (*laps, lap)
    old = len(laps) - 1 - KEPT_LINES
    if old < 0:
        return laps
    best = min(range(len(laps)), key=lambda i: laps[i].time)
    return tuple(_bare(one) if i <= old and i != best and len(one.line) else one for i, one in enumerate(laps))


def _bare(lap: DrivenLap) -> DrivenLap:
    return replace(lap, line=np.zeros((0, 2)), speed=np.zeros(0))
