"""One step of a driver, ready to be looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.car_file import Car
from firstlap.drivers.registry import Preparation, driver_kind
from firstlap.errors import InputError
from firstlap.race import start_race
from firstlap.racer import step_core
from firstlap.setup_file import Setup
from firstlap.tracks.track import Track


@dataclass(frozen=True)
class Moment:
    """A step as it happened. Lengths in metres, in base_link; `walls` are the true ones, where known."""

    title: str
    subtitle: str
    driver: str
    trace: Mapping[str, Any]
    params: Mapping[str, Mapping[str, float]]
    car: Mapping[str, float]
    speed: float
    yaw_rate: float
    steering_angle: float
    walls: list[tuple[npt.NDArray[np.float64], bool]]
    outcome: str = ""


def explain_race(track: Track, setup: Setup, car: Car, at: float, *, seed: int, reverse: bool) -> Moment:
    """The step at `at` metres of way from the start line, or the last one where the race ended before.

    The car drives there, so that its memory is as in a race. Raises InputError.
    """
    if reverse:
        track = track.reversed()
    if not 0.0 <= at <= 100.0 * track.length:
        furthest = 100.0 * track.length
        raise InputError(
            f"--at {at:g}: allowed is 0 to {furthest:.0f} m; a lap of {track.name} is {track.length:.1f} m"
        )
    kind = driver_kind(setup.driver)
    driver = kind.make(setup.params(car.core), car, kind.prepare(track, setup, car, seed, None))
    running = start_race(track, driver, car, laps=int(at // track.length) + 2, seed=seed)
    going = running.advance()
    while going and _way(running) < at:
        going = running.advance()
    measured = running.measured()
    outcome = "" if going else running.result()["outcome"]
    x, y, yaw = running.pose
    return Moment(
        title=f"{Path(track.name).stem if '/' in track.name else track.name}, {_way(running):.1f} m",
        subtitle=f"{'reverse, ' if reverse else ''}{setup.title}, car {car.name}, seed {seed}, "
        f"{running.time:.2f} s after the start",
        driver=setup.driver,
        trace=driver.trace,
        params=setup.params(car.core).values(),
        car=car.core.values()["geometry"],
        speed=measured["speed"],
        yaw_rate=measured["yaw_rate"],
        steering_angle=measured["steering_angle"],
        walls=[(_to_car(wall, x, y, yaw), visible) for wall, visible in zip(track.walls, track.visible, strict=True)],
        outcome=outcome,
    )


def _way(running: _core.Race) -> float:
    """Metres along the centerline since the start."""
    s, length = running.s, running.track_length
    before_the_line = running.laps_done() == 0 and running.time < 1.0 and s > 0.5 * length
    return float(running.laps_done() * length + s - (length if before_the_line else 0.0))


def _to_car(points: npt.NDArray[np.float64], x: float, y: float, yaw: float) -> npt.NDArray[np.float64]:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray((points - (x, y)) @ np.array([[c, -s], [s, c]]))


def explain_scan(path: Path, setup: Setup, car: Car, index: int, speed: float) -> Moment:
    """The step on scan `index` of an .npz recording, after the scans before it. Raises InputError.

    The file holds ranges (N, beams) in metres, angle_min and angle_increment in rad, and may hold range_max, stamps
    (N,), speed, yaw_rate and steering_angle (N,); `speed` [m/s] serves where it has none.
    """
    recording = _read_recording(path)
    ranges = recording["ranges"]
    if not -len(ranges) <= index < len(ranges):
        raise InputError(f"{path}: has scans 0 to {len(ranges) - 1}, asked for {index}")
    index %= len(ranges)
    stamps = recording.get("stamps", np.arange(len(ranges)) * 0.025)
    kind = driver_kind(setup.driver)
    if kind.needs_map:
        raise InputError(f"--scan: the driver {kind.name} needs a map; a scan alone has none")
    driver = kind.make(setup.params(car.core), car, Preparation())
    state = {"speed": speed, "yaw_rate": 0.0, "steering_angle": 0.0}
    for i in range(max(0, index - 200), index + 1):
        state = {name: float(recording[name][i]) if name in recording else value for name, value in state.items()}
        step_core(
            driver.core,
            ranges[i],
            speed=state["speed"],
            yaw_rate=state["yaw_rate"],
            steering_angle=state["steering_angle"],
            dt=float(stamps[i] - stamps[i - 1]) if i else 0.025,
            angle_min=float(recording["angle_min"]),
            angle_increment=float(recording["angle_increment"]),
            range_max=float(recording.get("range_max", 30.0)),
        )
    return Moment(
        title=f"{path.stem}, scan {index}",
        subtitle=f"{setup.title}, car {car.name}, {ranges.shape[1]} beams",
        driver=setup.driver,
        trace=driver.trace,
        params=setup.params(car.core).values(),
        car=car.core.values()["geometry"],
        speed=state["speed"],
        yaw_rate=state["yaw_rate"],
        steering_angle=state["steering_angle"],
        walls=[],
    )


def _read_recording(path: Path) -> dict[str, npt.NDArray[np.float64]]:
    try:
        with np.load(path, allow_pickle=False) as file:
            wanted = ("ranges", "angle_min", "angle_increment", "range_max", "stamps", "speed", "yaw_rate",
                      "steering_angle")  # fmt: skip
            recording = {key: np.asarray(file[key], dtype=np.float64) for key in wanted if key in file}
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except Exception as error:
        raise InputError(f"{path}: not an .npz recording of scans ({type(error).__name__})") from None
    missing = [key for key in ("ranges", "angle_min", "angle_increment") if key not in recording]
    if missing:
        raise InputError(f"{path}: has no '{missing[0]}'; expected ranges, angle_min and angle_increment")
    recording["ranges"] = np.atleast_2d(recording["ranges"])
    count = len(recording["ranges"])
    for key, value in recording.items():
        single = key in ("angle_min", "angle_increment", "range_max")
        if value.ndim != (0 if single else 2 if key == "ranges" else 1) or (not single and len(value) != count):
            raise InputError(f"{path}: '{key}' has the shape {value.shape}, which does not fit {count} scans")
    return recording
