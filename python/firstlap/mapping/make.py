"""From a track or a recording to a map: drive or read, match, close the loop, draw."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from firstlap.car_file import Car
from firstlap.errors import InputError
from firstlap.mapping.drive import MappingDrive
from firstlap.mapping.observation import Observation
from firstlap.mapping.occupancy_map import OccupancyMap, draw_map
from firstlap.mapping.parameters import MapSettings, map_settings
from firstlap.mapping.pose_graph import load_gtsam, optimise
from firstlap.mapping.slam import Mapper
from firstlap.scan import laser_of
from firstlap.setup_file import Setup, load_setup
from firstlap.tracks.track import FloatArray, Track

SCANS_PER_LOOK = 40
ROUNDS = 2  # a second, from better poses and with odometry's scale known


class Look(Protocol):
    """Told what is being done, how much of it is done, and of how much in all."""

    def __call__(self, what: str, done: float, total: float) -> object: ...


def _look_away(what: str, done: float, total: float) -> None:
    """For callers that do not watch."""


@dataclass(frozen=True)
class MapResult:
    """A map and how it came about. poses: (N, 3) of the kept scans, in the map's frame; before: before the loop
    was closed. travelled: [m] by odometry."""

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
            "travelled": round(self.mapper.travelled, 3),
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


def map_track(
    track: Track,
    setup: Setup | None = None,
    car: Car | None = None,
    *,
    seed: int = 1,
    settings: MapSettings | None = None,
    look: Look = _look_away,
) -> MapResult:
    """Drives a slow lap in the simulator and maps it, from scans and noisy odometry. Raises InputError."""
    from firstlap.car_file import load_car

    load_gtsam()
    settings, car = settings or map_settings(), car or load_car("default")
    drive = MappingDrive(track, setup or load_setup("sure"), car, settings.get("drive.speed"), seed)
    mapper = Mapper(settings, car.core)

    def going(seen: Mapper) -> bool:
        if seen.travelled > settings.get("drive.give_up"):
            raise InputError(f"{track.name}: {_no_loop(seen)} (drive.give_up)")
        if seen.scans % SCANS_PER_LOOK == 0:
            look("mapping lap", seen.travelled, track.length + settings.get("drive.overlap"))
        return not seen.closed or seen.overlap < settings.get("drive.overlap")

    return finish(_run(mapper, drive, going), laser_of(car.core.values()["geometry"]), look)


def map_observations(
    observations: Iterable[Observation],
    car: Car,
    *,
    name: str,
    total: int,
    settings: MapSettings | None = None,
    look: Look = _look_away,
) -> MapResult:
    """Maps what was recorded. name: for messages; total: number of scans. Raises InputError."""
    load_gtsam()
    mapper = Mapper(settings or map_settings(), car.core)

    def going(seen: Mapper) -> bool:
        if seen.scans % SCANS_PER_LOOK == 0:
            look("matching", seen.scans, total)
        return True

    _run(mapper, observations, going)
    if not mapper.closed:
        raise InputError(f"{name}: {_no_loop(mapper)}")
    return finish(mapper, laser_of(car.core.values()["geometry"]), look)


def finish(mapper: Mapper, laser: tuple[float, float], look: Look = _look_away) -> MapResult:
    """Pose graph and drawing, after the last scan. Raises InputError."""
    count = len(mapper.keyframes)
    before = np.array([keyframe.pose for keyframe in mapper.keyframes])
    poses, scale, edges = before, 1.0, []
    for turn in range(ROUNDS):
        look("closing the loop", turn, ROUNDS)
        edges = mapper.edges(poses)
        scale = mapper.odometry_scale(edges)
        poses = optimise(mapper, edges, poses, scale)
    drawn = draw_map(mapper.keyframes, poses, laser, mapper.settings, lambda number: look("drawing", number + 1, count))
    return MapResult(drawn, poses, before, mapper, len(edges), scale)


def _run(mapper: Mapper, observations: Iterable[Observation], going: Callable[[Mapper], bool]) -> Mapper:
    for seen in observations:
        mapper.add(seen)
        if not going(mapper):
            break
    return mapper


def _no_loop(mapper: Mapper) -> str:
    if not mapper.keyframes:
        return "no scans"
    end = mapper.keyframes[-1].pose
    if mapper.poor > 0.2 * len(mapper.keyframes):
        return (
            f"{mapper.poor} of {len(mapper.keyframes)} scans match nothing before them, and no loop closes; expected "
            "scans of walls, dense enough to see their direction (beams less than about 4 degrees apart)"
        )
    return (
        f"no loop closes in {mapper.travelled:.1f} m: the last scan lies {np.hypot(end[0], end[1]):.1f} m from the "
        "first; expected a drive that passes where it has been, in the same direction, for some metres"
    )
