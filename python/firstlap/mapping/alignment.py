"""Aligns a map with true walls by the best rigid fit."""

from __future__ import annotations

import numpy as np
import shapely

from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.poses import between, compose, transform
from firstlap.tracks.track import FloatArray, Track

ROUNDS = 20
FAR = 0.3


def align(drawn: OccupancyMap, track: Track, start: tuple[float, float, float]) -> FloatArray:
    """(3,) pose of the map's frame in the track's frame by the best rigid fit of the walls, near the initial guess from
    `start` (base_link in the track's frame)."""
    known = np.array(drawn.start or (0.0, 0.0, 0.0))
    first = compose(np.array(start), between(known, np.zeros(3)))
    at_start = transform(first, drawn.wall_points())
    return compose(_best_fit(at_start, walls_of(track)), first)


def walls_of(track: Track) -> Walls:
    """The walls of a track that are visible to a LiDAR."""
    seen = [wall for wall, visible in zip(track.walls, track.visible, strict=True) if visible]
    return Walls(np.vstack([np.hstack([wall[:-1], wall[1:]]) for wall in seen]))


class Walls:
    """Line segments (N, 4): x, y of both ends [m]."""

    def __init__(self, segments: FloatArray) -> None:
        self._segments = segments
        self._tree = shapely.STRtree(shapely.linestrings(segments.reshape(-1, 2, 2)))

    def nearest(self, points: FloatArray) -> FloatArray:
        """(N, 2) the nearest wall point of each point."""
        a, b = np.split(self._segments[self._tree.nearest(shapely.points(points))], 2, axis=1)
        along = b - a
        t = np.sum((points - a) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12)
        return np.asarray(a + np.clip(t, 0.0, 1.0)[:, None] * along)

    def distances(self, points: FloatArray) -> FloatArray:
        """(N,) distance [m] of each of the points (N, 2) from the nearest wall."""
        return np.hypot(*(points - self.nearest(points)).T)


def _best_fit(points: FloatArray, walls: Walls) -> FloatArray:
    """(3,) the rigid motion that fits the points to the walls by robust least squares."""
    pose = np.zeros(3)
    sample = points[:: max(1, len(points) // 20_000)]
    for _ in range(ROUNDS):
        moved = transform(pose, sample)
        away = walls.nearest(moved) - moved
        near = np.hypot(*away.T) < FAR
        if near.sum() < 3:
            break
        step = _normal_step(moved[near], away[near])
        pose = compose(step, pose)
        if np.abs(step).max() < 1e-5:
            break
    return pose


def _normal_step(points: FloatArray, away: FloatArray) -> FloatArray:
    """(3,) one Gauss-Newton step of the point-to-wall distances."""
    distance = np.hypot(*away.T)
    normal = away / np.maximum(distance, 1e-9)[:, None]
    jacobian = np.column_stack([normal, normal[:, 1] * points[:, 0] - normal[:, 0] * points[:, 1]])
    return np.asarray(np.linalg.lstsq(jacobian, distance, rcond=None)[0])
