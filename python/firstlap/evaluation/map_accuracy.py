"""Accuracy of maps with known ground truth."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from firstlap.config.car_file import Car
from firstlap.drivers.racer import Racer
from firstlap.mapping.alignment import align, walls_of
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.poses import transform
from firstlap.sim.race import start_race
from firstlap.tracks.track import FloatArray, Track

COMPLETE_WITHIN = 0.1


@dataclass(frozen=True)
class MapError:
    """Distances [m] of the map's wall points (centers of occupied cells) from the true walls.

    rms_start: with the map's start aligned with the true start. rms, p95, max: after the best rigid fit of the whole
    map. complete: share of the true walls, solid and visible, with a wall point within 0.1 m.
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
    """The true pose of base_link at the start of a race, in the track's frame [m, rad]."""
    x, y, yaw = start_race(track, Racer(car=car), car, laps=1).pose
    return x, y, yaw


def check_map(drawn: OccupancyMap, track: Track, start: tuple[float, float, float]) -> MapError:
    """Compares the map's walls with the track's; start: true pose of the map's frame in the track's frame."""
    walls = walls_of(track)
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
