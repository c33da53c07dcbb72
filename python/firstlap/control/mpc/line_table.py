"""A table of the racing line by arc length for the controller."""

from __future__ import annotations

import numpy as np

from firstlap.planning.raceline.corridor import BINS, Corridor
from firstlap.planning.raceline.line import RaceLine
from firstlap.planning.raceline.path import closed_spline, path_through
from firstlap.tracks.track import FloatArray

SPACING = 0.1
ZONES = 3
"""Number of parts of the car's side with separate wall constraints."""
WINDOW = 3.0


class LineTable:
    """Curvature, speed and lateral clearance, every 0.1 m along a closed line."""

    def __init__(self, line: RaceLine, corridor: Corridor, margin: float) -> None:
        spline, chord = closed_spline(line.path.points)
        count = max(16, round(chord / SPACING))
        at = np.linspace(0.0, chord, count, endpoint=False)
        path = path_through(spline(at))
        self.points, self.normal = path.points, path.normal
        self.heading = np.unwrap(path.heading)
        self.length = path.length
        self.spacing = self.length / count
        knots = np.append(line.path.stations, line.length)
        speed = np.interp(at / chord * line.length, knots, np.append(line.speed, line.speed[0]))
        left, right = corridor.rooms(path.poses, margin)
        zone = BINS // ZONES
        self.zones = corridor.bins(margin).reshape(ZONES, zone).mean(axis=1)
        rooms = [side.reshape(count, ZONES, zone).min(axis=2) for side in (left, right)]
        self.columns = np.column_stack([path.curvature, speed, *rooms])
        self.columns = np.vstack([self.columns, self.columns[:1]])
        self.curvature = np.ascontiguousarray(self.columns[:, 0])
        self.bending = np.diff(self.curvature)
        self._count = count

    def bend(self, s: FloatArray) -> FloatArray:
        """Curvature [1/m] at arc lengths of any shape."""
        at = s / self.spacing
        index = np.floor(at)
        part = at - index
        i = index.astype(np.intp) % self._count
        return self.curvature[i] + part * self.bending[i]

    def at(self, s: FloatArray) -> FloatArray:
        """(len(s), 2 + 2 ZONES): curvature, speed, clearances left, clearances right at arc lengths (K,)."""
        place = s / self.spacing
        index = np.floor(place)
        i = index.astype(np.intp) % self._count
        part = (place - index)[:, None]
        return self.columns[i] * (1.0 - part) + self.columns[i + 1] * part

    def locate(self, x: float, y: float, yaw: float, last: float | None) -> tuple[float, float, float]:
        """(s, offset to the left, heading error) of a pose; near the arc length `last` if that is known."""
        dx, dy = self.points[:, 0] - x, self.points[:, 1] - y
        square = dx * dx + dy * dy
        if last is None:
            square = square + np.where(np.cos(self.heading - yaw) > 0.0, 0.0, 100.0)
        else:
            behind = np.abs((np.arange(self._count) - last / self.spacing + 0.5 * self._count) % self._count)
            square = np.where(np.abs(behind - 0.5 * self._count) * self.spacing < WINDOW, square, np.inf)
        i = int(np.argmin(square))
        nx, ny = float(self.normal[i, 0]), float(self.normal[i, 1])
        offset = -(float(dx[i]) * nx + float(dy[i]) * ny)
        bend = float(self.curvature[i])
        along = -(float(dx[i]) * ny - float(dy[i]) * nx) / max(0.2, 1.0 - bend * offset)
        error = yaw - float(self.heading[i]) - bend * along
        error = (error + np.pi) % (2.0 * np.pi) - np.pi
        return (i * self.spacing + along) % self.length, offset, float(error)
