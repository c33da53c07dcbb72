"""Makes a map from observations: matching, loop closure, drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.mapping.observation import Observation
from firstlap.mapping.occupancy_map import OccupancyMap, draw_map
from firstlap.mapping.parameters import MapSettings, map_settings
from firstlap.mapping.pose_graph import load_gtsam, optimize
from firstlap.mapping.slam import Mapper
from firstlap.perception.scan import laser_of
from firstlap.tracks.track import FloatArray

SCANS_PER_CALLBACK = 40
ROUNDS = 2  # a second, from better poses and with odometry's scale known


class MappingProgress(Protocol):
    """Called with the current activity, the amount done and the total."""

    def __call__(self, what: str, done: float, total: float) -> object: ...


def no_progress(what: str, done: float, total: float) -> None:
    """Ignores the progress."""


@dataclass(frozen=True)
class MapResult:
    """A map and its keyframes. poses: (N, 3) of the keyframes in the map's frame; before: their poses before the loop
    was closed. traveled: distance by odometry [m]."""

    map: OccupancyMap
    poses: FloatArray
    before: FloatArray
    mapper: Mapper
    edges: int
    odometry_scale: float

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap map --json`."""
        rows, columns = self.map.cells.shape
        moved = np.hypot(*(self.poses - self.before)[:, :2].T)
        return {
            "travelled": round(self.mapper.traveled, 3),
            "loop_closed_at": self.mapper.closed_at,
            "scans": self.mapper.scans,
            "kept_scans": len(self.poses),
            "matches": self.edges,
            "loops": len(self.mapper.loops),
            "poor_matches": self.mapper.poor,
            "odometry_scale": round(self.odometry_scale, 5),
            "moved_by_loop": round(float(moved.max()), 4),
            "resolution": self.map.resolution,
            "columns": columns,
            "rows": rows,
            "origin": list(self.map.origin),
            "start": list(self.map.start or ()),
        }


def map_observations(
    observations: Iterable[Observation],
    car: Car,
    *,
    name: str,
    total: int,
    settings: MapSettings | None = None,
    on_progress: MappingProgress = no_progress,
) -> MapResult:
    """Makes a map from observations. name: for messages; total: number of scans. Raises InputError."""
    load_gtsam()
    mapper = Mapper(settings or map_settings(), car.core)

    def going(seen: Mapper) -> bool:
        if seen.scans % SCANS_PER_CALLBACK == 0:
            on_progress("matching", seen.scans, total)
        return True

    mapped(mapper, observations, going)
    if not mapper.closed:
        raise InputError(f"{name}: {no_loop(mapper)}")
    return finish(mapper, laser_of(car.core.values()["geometry"]), on_progress)


def finish(mapper: Mapper, laser: tuple[float, float], on_progress: MappingProgress = no_progress) -> MapResult:
    """Optimizes the pose graph and draws the map, after the last scan. Raises InputError."""
    count = len(mapper.keyframes)
    before = np.array([keyframe.pose for keyframe in mapper.keyframes])
    poses, scale, edges = before, 1.0, []
    for turn in range(ROUNDS):
        on_progress("closing the loop", turn, ROUNDS)
        edges = mapper.edges(poses)
        scale = mapper.odometry_scale(edges)
        poses = optimize(mapper, edges, poses, scale)
    drawn = draw_map(
        mapper.keyframes, poses, laser, mapper.settings, lambda number: on_progress("drawing", number + 1, count)
    )
    return MapResult(drawn, poses, before, mapper, len(edges), scale)


def mapped(mapper: Mapper, observations: Iterable[Observation], going: Callable[[Mapper], bool]) -> Mapper:
    """The mapper after adding observations while `going` returns true."""
    for seen in observations:
        mapper.add(seen)
        if not going(mapper):
            break
    return mapper


def no_loop(mapper: Mapper) -> str:
    """The message for a drive without a loop closure."""
    if not mapper.keyframes:
        return "no scans"
    end = mapper.keyframes[-1].pose
    if mapper.poor > 0.2 * len(mapper.keyframes):
        return (
            f"{mapper.poor} of {len(mapper.keyframes)} scans match no earlier one, and no loop was closed; expected "
            "scans of walls with beams less than about 4 degrees apart"
        )
    return (
        f"no loop was closed in {mapper.traveled:.1f} m: the last scan is {np.hypot(end[0], end[1]):.1f} m from the "
        "first; expected a drive that revisits its beginning in the same direction for some meters"
    )
