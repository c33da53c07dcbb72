"""How true a map is, where the truth is known."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import shapely

from firstlap.car_file import Car
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.poses import between, compose, transform
from firstlap.race import start_race
from firstlap.racer import Racer
from firstlap.tracks.track import FloatArray, Track

ROUNDS = 20
FAR = 0.3
COMPLETE_WITHIN = 0.1


@dataclass(frozen=True)
class MapError:
    """Distances [m] of the map's wall points (centres of occupied cells) from the true walls.

    rms_start: with the map's start laid on the true start. rms, p95, max: after the best rigid fit of the whole map.
    complete: share of the true walls, solid and visible, with a wall point within 0.1 m.
    """

    points: int
    rms_start: float
    rms: float
    p95: float
    max: float
    complete: float

    def to_dict(self) -> dict[str, Any]:
        """Rounded to 0.1 mm."""
        return {name: round(value, 4) for name, value in asdict(self).items()}


def true_start(track: Track, car: Car) -> tuple[float, float, float]:
    """Where base_link truly stands when a race begins, in the track's frame [m, rad]."""
    x, y, yaw = start_race(track, Racer("sure", car), car, laps=1).pose
    return x, y, yaw


def check_map(drawn: OccupancyMap, track: Track, start: tuple[float, float, float]) -> MapError:
    """The map's walls against the track's; start: where the map's frame truly lies, in the track's."""
    walls = _walls_of(track)
    points = drawn.wall_points()
    rms_start = _rms(walls.distances(transform(np.array(start), points)))
    fitted = transform(align(drawn, track, start), points)
    distances = walls.distances(fitted)
    return MapError(
        points=len(points),
        rms_start=rms_start,
        rms=_rms(distances),
        p95=float(np.percentile(distances, 95)),
        max=float(distances.max()),
        complete=_complete(fitted, track),
    )


def align(drawn: OccupancyMap, track: Track, start: tuple[float, float, float]) -> FloatArray:
    """(3,) pose of the map's frame in the track's by the best rigid fit of its walls, near where `start` (base_link
    in the track's frame) lays it."""
    known = np.array(drawn.start or (0.0, 0.0, 0.0))
    first = compose(np.array(start), between(known, np.zeros(3)))
    at_start = transform(first, drawn.wall_points())
    return compose(_best_fit(at_start, _walls_of(track)), first)


def _walls_of(track: Track) -> _Walls:
    seen = [wall for wall, visible in zip(track.walls, track.visible, strict=True) if visible]
    return _Walls(np.vstack([np.hstack([wall[:-1], wall[1:]]) for wall in seen]))


class _Walls:
    def __init__(self, segments: FloatArray) -> None:
        self._segments = segments
        self._tree = shapely.STRtree(shapely.linestrings(segments.reshape(-1, 2, 2)))

    def nearest(self, points: FloatArray) -> FloatArray:
        """(N, 2) the nearest point of a wall to each."""
        a, b = np.split(self._segments[self._tree.nearest(shapely.points(points))], 2, axis=1)
        along = b - a
        t = np.sum((points - a) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12)
        return np.asarray(a + np.clip(t, 0.0, 1.0)[:, None] * along)

    def distances(self, points: FloatArray) -> FloatArray:
        return np.hypot(*(points - self.nearest(points)).T)


def _best_fit(points: FloatArray, walls: _Walls) -> FloatArray:
    """(3,) the rigid motion that brings the points onto the walls, in least squares; strays do not pull."""
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
    """(3,) one Gauss-Newton step along the directions in which the walls lie."""
    distance = np.hypot(*away.T)
    normal = away / np.maximum(distance, 1e-9)[:, None]
    jacobian = np.column_stack([normal, normal[:, 1] * points[:, 0] - normal[:, 0] * points[:, 1]])
    return np.asarray(np.linalg.lstsq(jacobian, distance, rcond=None)[0])


def _complete(points: FloatArray, track: Track) -> float:
    from scipy.spatial import cKDTree

    solid = [wall for wall, seen, hard in zip(track.walls, track.visible, track.solid, strict=True) if seen and hard]
    samples = np.vstack([_every(wall, 0.05) for wall in solid])
    distances, _ = cKDTree(points).query(samples)
    return float(np.mean(distances < COMPLETE_WITHIN))


def _every(line: FloatArray, spacing: float) -> FloatArray:
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.arange(0.0, s[-1], spacing)
    return np.column_stack([np.interp(at, s, line[:, 0]), np.interp(at, s, line[:, 1])])


def _rms(distances: FloatArray) -> float:
    return float(np.sqrt(np.mean(distances**2)))
