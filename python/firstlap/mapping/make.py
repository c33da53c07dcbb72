"""From observations to a map: match, close the loop, draw."""

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

SCANS_PER_LOOK = 40
ROUNDS = 2  # a second, from better poses and with odometry's scale known


class MappingProgress(Protocol):
    """TraceHeader what is being done, how much of it is done, and of how much in all."""

    def __call__(self, what: str, done: float, total: float) -> object: ...


def no_progress(what: str, done: float, total: float) -> None:
    """For callers that do not watch."""


@dataclass(frozen=True)
class MapResult:
    """A map and how it came about. poses: (N, 3) of the kept scans, in the map's frame; before: before the loop
    was closed. traveled: [m] by odometry."""

    map: OccupancyMap
    poses: FloatArray
    before: FloatArray
    mapper: Mapper
    edges: int
    odometry_scale: float

    def to_dict(self) -> dict[str, Any]:
        """As `firstlap map --json` prints it."""
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
    look: MappingProgress = no_progress,
) -> MapResult:
    """Maps what was recorded. name: for messages; total: number of scans. Raises InputError."""
    load_gtsam()
    mapper = Mapper(settings or map_settings(), car.core)

    def going(seen: Mapper) -> bool:
        if seen.scans % SCANS_PER_LOOK == 0:
            look("matching", seen.scans, total)
        return True

    mapped(mapper, observations, going)
    if not mapper.closed:
        raise InputError(f"{name}: {no_loop(mapper)}")
    return finish(mapper, laser_of(car.core.values()["geometry"]), look)


def finish(mapper: Mapper, laser: tuple[float, float], look: MappingProgress = no_progress) -> MapResult:
    """Pose graph and drawing, after the last scan. Raises InputError."""
    count = len(mapper.keyframes)
    before = np.array([keyframe.pose for keyframe in mapper.keyframes])
    poses, scale, edges = before, 1.0, []
    for turn in range(ROUNDS):
        look("closing the loop", turn, ROUNDS)
        edges = mapper.edges(poses)
        scale = mapper.odometry_scale(edges)
        poses = optimize(mapper, edges, poses, scale)
    drawn = draw_map(mapper.keyframes, poses, laser, mapper.settings, lambda number: look("drawing", number + 1, count))
    return MapResult(drawn, poses, before, mapper, len(edges), scale)


def mapped(mapper: Mapper, observations: Iterable[Observation], going: Callable[[Mapper], bool]) -> Mapper:
    """The mapper with the observations added, as long as `going` says so."""
    for seen in observations:
        mapper.add(seen)
        if not going(mapper):
            break
    return mapper


def no_loop(mapper: Mapper) -> str:
    """Why there is no map, for people."""
    if not mapper.keyframes:
        return "no scans"
    end = mapper.keyframes[-1].pose
    if mapper.poor > 0.2 * len(mapper.keyframes):
        return (
            f"{mapper.poor} of {len(mapper.keyframes)} scans match nothing before them, and no loop closes; expected "
            "scans of walls, dense enough to see their direction (beams less than about 4 degrees apart)"
        )
    return (
        f"no loop closes in {mapper.traveled:.1f} m: the last scan lies {np.hypot(end[0], end[1]):.1f} m from the "
        "first; expected a drive that passes where it has been, in the same direction, for some metres"
    )
