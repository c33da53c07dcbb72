"""Preparation: a mapping lap, a map, and the racing line on it, without use of the true walls."""

from __future__ import annotations

import hashlib
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import Preparation, ProgressCallback
from firstlap.config.setup_file import DEFAULT_SETUP, load_setup
from firstlap.drivers.global_driver.cache import key_of, stored
from firstlap.drivers.global_driver.drivable_area import road_of
from firstlap.drivers.global_driver.params import Parts
from firstlap.drivers.mapping_drive import map_track
from firstlap.mapping.occupancy_map import OccupancyMap, read_map, write_map
from firstlap.planning.raceline.line import RaceLine, make_line
from firstlap.planning.raceline.line_file import load_line, write_line
from firstlap.planning.raceline.params import LineParams
from firstlap.tracks.ros_map import load_ros_map
from firstlap.tracks.track import Track
from firstlap.tracks.track_hash import track_hash

MAPPING_SETUP = DEFAULT_SETUP
MAP_FILE, ROAD_FILE, LINE_FILE = "map.yaml", "road.yaml", "line.csv"
MAP_SHARE, LINE_SHARE = 0.6, 0.4
"""Shares of the total progress."""


@dataclass(frozen=True)
class Prepared:
    """The preparation of the driver. walls: the road on the map as a track; line and plans use nothing else."""

    known: OccupancyMap
    walls: Track
    line: RaceLine


def prepare(
    track: Track, parts: Parts, car: Car, seed: int, on_progress: ProgressCallback | None = None
) -> Preparation:
    """Map and line, from the cache or made now; the durations are those of making them.

    The mapping lap has the race's start and direction of travel. Raises InputError.
    """
    say = on_progress or (lambda _what, _share: None)
    map_folder, mapped, map_known = _map(track, parts, car, seed, say)
    walls = _read_walls(map_folder / ROAD_FILE, track.name)
    line_folder, lined, line_known = _line(map_folder, walls, parts, car, say)
    line = load_line(line_folder / LINE_FILE, walls, car)
    driving, computing = mapped["driving"], mapped["computing"] + lined["computing"]
    notes = [
        f"mapping lap of {mapped['travelled']:.1f} m, {driving:.1f} s" + (" (cached)" if map_known else ""),
        f"line of {line.length:.1f} m, {line.lap_time:.2f} s per lap" + (" (cached)" if line_known else ""),
        *lined["notes"],
    ]
    return Preparation(
        seconds=driving + computing,
        notes=tuple(notes),
        given=Prepared(read_map(map_folder / MAP_FILE), walls, line),
        driving=driving,
        computing=computing,
        cached=map_known and line_known,
    )


def _map(track: Track, parts: Parts, car: Car, seed: int, say: ProgressCallback) -> tuple[Path, dict[str, Any], bool]:
    said = {
        "what": "map",
        "track": track_hash(track),
        "start": track.start_pose(),
        "car": car.core.values(),
        "seed": seed,
        "mapping": parts.mapping.core.values(),
        "setup": load_setup(MAPPING_SETUP).params(car.core).values(),
    }

    def make(folder: Path) -> dict[str, Any]:
        begin = time.process_time()
        result = map_track(
            track,
            load_setup(MAPPING_SETUP),
            car,
            seed=seed,
            settings=parts.mapping,
            on_progress=lambda what, done, total: say(what, MAP_SHARE * min(1.0, done / max(total, 1e-9))),
        )
        write_map(result.map, folder / MAP_FILE)
        write_map(road_of(result.map, result.poses[:, :2]), folder / ROAD_FILE)
        return {
            "driving": result.mapper.keyframes[-1].time,
            "computing": time.process_time() - begin,
            "travelled": result.mapper.traveled,
        }

    return stored(key_of(said), make)


def _read_walls(path: Path, name: str) -> Track:
    try:
        return load_ros_map(path)
    except InputError as error:
        reason = str(error).removeprefix(f"{path}: ")
        raise InputError(f"{name}: the map of the mapping lap is not a valid track: {reason}") from None


def _line(
    map_folder: Path, walls: Track, parts: Parts, car: Car, say: ProgressCallback
) -> tuple[Path, dict[str, Any], bool]:
    said = {
        "what": "line",
        "map": _content(map_folder),
        "car": car.core.values(),
        "line": asdict(parts.line),
    }

    def make(folder: Path) -> dict[str, Any]:
        begin = time.process_time()
        line = _made(walls, car, parts.line, say)
        write_line(line, folder / LINE_FILE)
        return {"computing": time.process_time() - begin, "notes": line.notes}

    return stored(key_of(said), make)


def _made(walls: Track, car: Car, params: LineParams, say: ProgressCallback) -> RaceLine:
    def tell(what: str, share: float) -> None:
        say(f"least {what}", MAP_SHARE + LINE_SHARE * share)

    line = make_line(walls, car, params, tell)
    if not np.isfinite(line.path.points).all():
        raise InputError(f"{walls.name}: no racing line was found on the map")
    return line


def _content(folder: Path) -> str:
    digest = hashlib.sha256()
    for file in sorted([*folder.glob("map.*"), *folder.glob("road.*")]):
        digest.update(file.read_bytes())
    return digest.hexdigest()
