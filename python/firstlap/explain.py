"""One step of the method, ready to be looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.car_file import Car
from firstlap.errors import InputError
from firstlap.output import check_readable
from firstlap.race import start_race
from firstlap.racer import Racer
from firstlap.setup_file import Setup
from firstlap.tracks.track import Track

FASTEST = 100.0


@dataclass(frozen=True)
class Moment:
    """A step as it happened. Lengths in metres, in base_link; `walls` are the true ones, where known."""

    title: str
    subtitle: str
    trace: Mapping[str, Any]
    params: Mapping[str, Mapping[str, float]]
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
    racer = Racer(setup, car)
    running = start_race(track, racer, car, laps=int(at // track.length) + 2, seed=seed)
    going = running.advance()
    while going and _way(running) < at:
        going = running.advance()
    measured = running.measured()
    outcome = "" if going else running.result()["outcome"]
    x, y, yaw = running.pose
    return Moment(
        title=f"{Path(track.name).stem if '/' in track.name else track.name}, {_way(running):.1f} m",
        subtitle=f"{'reverse, ' if reverse else ''}setup {setup.name}, car {car.name}, seed {seed}, "
        f"{running.time:.2f} s after the start",
        trace=racer.trace,
        params=setup.params(car.core).values(),
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
    if not 0.0 <= abs(speed) <= FASTEST:
        raise InputError(f"--speed {speed:g}: allowed is -{FASTEST:g} to {FASTEST:g} m/s")
    recording = _read_recording(path)
    ranges = recording["ranges"]
    if not -len(ranges) <= index < len(ranges):
        raise InputError(f"{path}: has scans 0 to {len(ranges) - 1}, asked for {index}")
    index %= len(ranges)
    stamps = recording.get("stamps", np.arange(len(ranges)) * 0.025)
    racer = Racer(setup, car)
    state = {"speed": speed, "yaw_rate": 0.0, "steering_angle": 0.0}
    for i in range(max(0, index - 200), index + 1):
        state = {name: float(recording[name][i]) if name in recording else value for name, value in state.items()}
        racer.step(
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
        subtitle=f"setup {setup.name}, car {car.name}, {ranges.shape[1]} beams",
        trace=racer.trace,
        params=setup.params(car.core).values(),
        speed=state["speed"],
        yaw_rate=state["yaw_rate"],
        steering_angle=state["steering_angle"],
        walls=[],
    )


def _read_recording(path: Path) -> dict[str, npt.NDArray[np.float64]]:
    check_readable(path, "an .npz recording of scans")
    try:
        with np.load(path, allow_pickle=False) as file:
            wanted = ("ranges", "angle_min", "angle_increment", "range_max", "stamps", "speed", "yaw_rate",
                      "steering_angle")  # fmt: skip
            recording = {key: np.asarray(file[key], dtype=np.float64) for key in wanted if key in file}
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
    _check_values(recording, path)
    return recording


def _check_values(recording: Mapping[str, npt.NDArray[np.float64]], path: Path) -> None:
    """Raises InputError where a recording holds no scan, or numbers that no LiDAR and no clock gives."""
    if recording["ranges"].size == 0:
        count, beams = recording["ranges"].shape
        raise InputError(f"{path}: is empty ({count} scans of {beams} beams); expected at least one scan")
    for key, value in recording.items():
        if key != "ranges" and not np.isfinite(value).all():
            where = "" if value.ndim == 0 else f"[{int(np.argmin(np.isfinite(value)))}]"
            raise InputError(f"{path}: '{key}'{where} is not a finite number")
    if recording["angle_increment"] == 0.0:
        raise InputError(f"{path}: 'angle_increment' is 0; expected rad from beam to beam, such as 0.00436")
    if "range_max" in recording and recording["range_max"] <= 0.0:
        raise InputError(f"{path}: 'range_max' is {recording['range_max']:g}; expected metres above 0")
    stamps = recording.get("stamps", np.zeros(0))
    standing = np.flatnonzero(np.diff(stamps) <= 0.0)
    if len(standing):
        first = int(standing[0]) + 1
        before, after = stamps[first - 1], stamps[first]
        what = "stands still" if before == after else "goes back"
        raise InputError(f"{path}: 'stamps' {what} at scan {first} ({before:g} to {after:g} s); expected rising times")
