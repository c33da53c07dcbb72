"""Static drawings: ground, true walls, and the lines of laps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firstlap.pitwall.frame import DrivenLap, Points, Pose, Scenery
from firstlap.pitwall.layers import GROUND, LAPS, MIDDLE, WALLS
from firstlap.pitwall.primitives import LineSegments, Sheet, Solid
from firstlap.pitwall.shapes import NOTHING, Segments, chain, dashed, joined, merged, wall_mesh
from firstlap.plots.colors import DROPPED, FAINT, GOOD, GRID, INK, LINE, WALL, rgb

WALL_HEIGHT = 0.12
"""[m] Height of drawn walls."""
UNKNOWN = 40.0
"""[m] Half size of the ground without a track; a multiple of five."""
AROUND = 12.0
"""[m] Margin of the ground around a track."""
SHOWN_LAPS = 5


class Ground:
    """Grid lines every meter and every five meters, around the track, or around the car without a track."""

    def __init__(self, sheet: Sheet) -> None:
        colors = ((1, rgb(GRID, 0.25)), (5, rgb(GRID)))
        names = {1: "meters", 5: "five_meters"}
        self._lines = [(every, LineSegments(sheet, f"{GROUND.node}/{names[every]}", c, 1.0)) for every, c in colors]
        self._moves = True

    def surround(self, scenery: Scenery) -> None:
        """Sets the track."""
        bounds = scenery.bounds()
        low, high = bounds if bounds else (np.full(2, -UNKNOWN), np.full(2, UNKNOWN))
        self._moves = bounds is None
        for every, lines in self._lines:
            lines.move(0.0, 0.0)
            lines.show(_grid(low - AROUND, high + AROUND, every))

    def show(self, pose: Pose) -> None:
        """Moves the ground with the car, without a track."""
        if self._moves:
            x, y = (UNKNOWN * round(value / UNKNOWN) for value in pose[:2])
            for _, lines in self._lines:
                lines.move(x, y)


class Walls:
    """True walls and centerline, if known."""

    def __init__(self, sheet: Sheet) -> None:
        self._sheet = sheet
        self._wall_mesh: Solid | None = None
        self._seen = LineSegments(sheet, f"{WALLS.node}/seen", rgb(INK), 2.0)
        self._unseen = LineSegments(sheet, f"{WALLS.node}/unseen", rgb(FAINT), 2.0)
        self._middle = LineSegments(sheet, f"{MIDDLE.node}/line", rgb(LINE, 0.4), 1.0)

    def surround(self, scenery: Scenery) -> None:
        """Replaces all walls."""
        pairs = list(zip(scenery.walls, scenery.visible, strict=True))
        seen = [wall for wall, visible in pairs if visible and len(wall) > 1]
        low_ones = [wall for wall, visible in pairs if not visible]
        self._build_wall_mesh(seen)
        self._seen.show(_all([chain(wall, 0.006) for wall in seen]))
        self._unseen.show(_all([dashed(wall, 0.01, 0.12, 0.1) for wall in low_ones]))
        middle = scenery.centerline
        closed = np.vstack([middle, middle[:1]]) if len(middle) > 1 else NOTHING
        self._middle.show(dashed(closed, 0.004, 0.2, 0.2))

    def _build_wall_mesh(self, walls: list[Points]) -> None:
        """Replaces the mesh: a mesh cannot change its shape."""
        if self._wall_mesh is not None:
            self._wall_mesh.remove()
        mesh = merged([wall_mesh(wall, WALL_HEIGHT) for wall in walls]) if walls else None
        self._wall_mesh = Solid(self._sheet, f"{WALLS.node}/fence", mesh, rgb(WALL)) if mesh else None


def _grid(low: Points, high: Points, every: int) -> Segments:
    """Lines at whole multiples of `every` meters, a centimeter below the ground's other drawings."""
    low, high = np.floor(low / every) * every, np.ceil(high / every) * every
    x = np.arange(low[0], high[0] + 0.5 * every, every)
    y = np.arange(low[1], high[1] + 0.5 * every, every)
    upright = joined(np.column_stack([x, 0 * x + low[1]]), np.column_stack([x, 0 * x + high[1]]), -0.01)
    level = joined(np.column_stack([0 * y + low[0], y]), np.column_stack([0 * y + high[0], y]), -0.01)
    return np.concatenate([upright, level])


def _all(pieces: list[Segments]) -> Segments:
    return np.concatenate(pieces) if pieces else chain(NOTHING, 0.0)


def best_of(laps: Sequence[DrivenLap]) -> DrivenLap | None:
    """The fastest flying lap; a standing-start lap only if there is no other."""
    flying = [lap for lap in laps if not lap.standing] or list(laps)
    return min(flying, key=lambda lap: lap.time, default=None)


class LapLines:
    """The lines of the last laps, older ones paler, and of the best lap."""

    def __init__(self, sheet: Sheet) -> None:
        self._lines = [LineSegments(sheet, f"{LAPS.node}/{i}", rgb(DROPPED, 0.16 * i), 1.5) for i in range(SHOWN_LAPS)]
        self._best = LineSegments(sheet, f"{LAPS.node}/best", rgb(GOOD), 2.5)
        self._shown: tuple[DrivenLap, ...] | None = None

    def show(self, laps: tuple[DrivenLap, ...]) -> None:
        """Shows complete laps, oldest first."""
        if self._shown is not None and _same(laps, self._shown):
            return
        self._shown = laps
        best = best_of(laps)
        last = [lap.line if lap is not best else NOTHING for lap in reversed(laps[-SHOWN_LAPS:])]
        for i, lines in enumerate(self._lines):
            lines.show(chain(last[i] if i < len(last) else NOTHING, 0.012 - 0.001 * i))
        self._best.show(chain(best.line if best else NOTHING, 0.014))


def _same(laps: tuple[DrivenLap, ...], others: tuple[DrivenLap, ...]) -> bool:
    """Whether the laps are the same; frames from another process contain copies."""
    return [(lap.number, lap.time) for lap in laps] == [(lap.number, lap.time) for lap in others]
