"""Continuity of perception and path from scan to scan, with the car's motion removed.

- Jump: distance of this scan's path, 1.5 m ahead of the front axle, from the path of the previous scan.
- Change of side: a wall point visible in this scan had the other label, left or right, in the previous scan.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from firstlap.recordings.recording import LONGEST_PAUSE

Floats = npt.NDArray[np.float64]

JUMP_AHEAD, BIG_JUMP = 1.5, 0.15
SAME_POINT = 0.15
"""[m] Wall points of two scans within this distance are the same: the sampling distance of walls."""


class Continuity:
    """Compares consecutive scans. Points (M, 2) in base_link [m]."""

    def __init__(self) -> None:
        self._path: Floats | None = None
        self._walls: tuple[Floats, Floats] | None = None
        self._state = (0.0, 0.0)

    def add(self, path: Floats, left: Floats, right: Floats, state: Floats, dt: float) -> tuple[float, bool]:
        """(jump [m] or NaN, whether a wall point changed its side).

        path: from the front axle on, empty if none was planned; left, right: visible wall points;
        state: speed and yaw rate; dt: [s] since the previous scan.
        """
        if dt > LONGEST_PAUSE:
            self._path = self._walls = None
        jump, changed = math.nan, False
        if self._walls is not None:
            before_left, before_right = (self._moved(side, state, dt) for side in self._walls)
            changed = is_touched(left, before_right, before_left) or is_touched(right, before_left, before_right)
        if self._path is not None:
            self._path = self._moved(self._path, state, dt)
        if len(path) > 1:
            jump = math.nan if self._path is None else jump_of(path, self._path)
            self._path = path
        if len(left) + len(right):
            self._walls = left, right
        self._state = (float(state[0]), float(state[1]))
        return jump, changed

    def _moved(self, points: Floats, state: Floats, dt: float) -> Floats:
        """The points in the current base_link, by dead reckoning."""
        speed, turn = 0.5 * (self._state[0] + state[0]), 0.5 * (self._state[1] + state[1]) * dt
        c, s = math.cos(turn), math.sin(turn)
        moved = points - (speed * dt * math.cos(0.5 * turn), speed * dt * math.sin(0.5 * turn))
        return np.asarray(moved @ np.array([[c, -s], [s, c]]))


def jump_of(path: Floats, before: Floats) -> float:
    """Distance [m] of the point 1.5 m along `path` from `before`, both (M, 2); NaN if the path is shorter."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    if way[-1] < JUMP_AHEAD:
        return math.nan
    point = np.array([np.interp(JUMP_AHEAD, way, path[:, 0]), np.interp(JUMP_AHEAD, way, path[:, 1])])
    start, along = before[:-1], np.diff(before, axis=0)
    t = np.clip(((point - start) * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.hypot(*(point - start - t[:, None] * along).T).min())


def is_touched(points: Floats, others: Floats, same: Floats) -> bool:
    """Whether one of `points` matches one of `others` and is nearer to it than to any of `same`."""
    if not len(points) or not len(others):
        return False
    to_others = _distances(points, others)
    suspects = to_others < SAME_POINT
    if not np.any(suspects):
        return False
    if not len(same):
        return True
    return bool(np.any(_distances(points[suspects], same) > to_others[suspects]))


def _distances(points: Floats, others: Floats) -> Floats:
    """(N,) from each point to the nearest of the others."""
    squares = (points[:, 0, None] - others[:, 0]) ** 2 + (points[:, 1, None] - others[:, 1]) ** 2
    return np.asarray(np.sqrt(squares.min(axis=1)))
