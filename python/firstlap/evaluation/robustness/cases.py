"""Robustness: races with one disturbance at a time."""

from __future__ import annotations

import math
import os
import statistics
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.drivers.racer import Racer
from firstlap.sim.race import RaceResult, race, start_race, under_conditions
from firstlap.tracks.cut_walls import with_pipes
from firstlap.tracks.track import Track

PIPE_LENGTH = 1.5  # [m] of the pipes between the joints of the sweep pipe_joints
GRAVITY = 9.81
RUN_UP = 15.0  # [m] driven before the sudden obstacle
RUN_OUT = 4.0  # [m] driven after it
STANDING = 1.5  # [s] standing still this long before it counts as stopped
BESIDE = (-0.3, 0.0, 0.3)  # [m] lateral offset of the obstacle's center from the line that the car drives without it
UNJUDGED = ("impossible", "before")
WAYS = ("race.obstacle_sight", "race.obstacle_at", "race.obstacle_offset")


@dataclass(frozen=True)
class Sweep:
    """One disturbance: which conditions it sets (section.name of `OPTION_FIELDS`), to `offset` + `scale` times a value.

    kind: 'field' sets them, 'joints' cuts the walls into pipes, 'box' puts the sudden obstacle on the line.
    """

    name: str
    title: str
    unit: str
    values: tuple[float, ...]
    kind: str
    sets: tuple[str, ...] = ()
    scale: float = 1.0
    fixed: tuple[tuple[str, float], ...] = ()
    offset: float = 0.0

    def conditions(self, value: float) -> dict[str, float]:
        """Options of a race at this value."""
        if self.kind != "field":
            return {}
        return {**dict(self.fixed), **dict.fromkeys(self.sets, self.offset + value * self.scale)}


SWEEPS = (
    Sweep("lost_beams", "single beams lost", "%", (0, 10, 20, 30, 40, 50, 60), "field", ("lidar.dropout_rate",), 0.01),
    Sweep("lost_sectors", "beams lost in sectors of 10°", "%", (0, 10, 20, 30, 40, 50, 60), "field",
          ("lidar.dropout_block_share",), 0.01, (("lidar.dropout_block_beams", 40),)),
    Sweep("range_noise", "range noise, standard deviation", "mm", (0, 10, 20, 30, 40, 50), "field",
          ("lidar.noise_sigma",), 0.001),
    Sweep("pipe_joints", f"joints between pipes of {PIPE_LENGTH:g} m", "m", (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8),
          "joints"),
    Sweep("scan_rate", "scan rate", "Hz", (40, 35, 30, 25, 20, 15, 10), "field", ("lidar.rate",)),
    Sweep("latency", "latency from scan to command", "ms", (0, 20, 40, 60, 80, 100), "field",
          ("race.delay_extra",), 0.001),
    Sweep("speed_measured", "measured speed reads high", "%", (0, -20, -15, -10, -5, 5, 10, 15, 20), "field",
          ("sensors.speed_scale_error",), 0.01),
    Sweep("speed_constant", "car faster than commanded and measured", "%",
          (0, -20, -15, -10, -5, 5, 10, 15, 20), "field", ("vehicle.speed_constant_error",), 0.01),
    Sweep("laser_yaw", "LiDAR yaw error, left", "°", (0, -6, -4, -2, -1, 1, 2, 4, 6), "field",
          ("sensors.laser_yaw_error",), math.pi / 180.0),
    Sweep("laser_ahead", "LiDAR position error, forward", "mm", (0, -100, -50, 50, 100), "field",
          ("sensors.laser_x_error",), 0.001),
    Sweep("laser_left", "LiDAR position error, left", "mm", (0, -100, -50, -25, 25, 50, 100), "field",
          ("sensors.laser_y_error",), 0.001),
    Sweep("range_scale", "range scale error", "%", (0, -10, -5, -2, 2, 5, 10), "field",
          ("lidar.range_scale",), 0.01, offset=1.0),
    Sweep("steering_trim", "steering trim, left", "°", (0, -6, -4, -2, -1, 1, 2, 4, 6), "field",
          ("vehicle.steering_trim",), math.pi / 180.0),
    Sweep("steering_gain", "steering gain", "%", (100, 60, 70, 80, 90, 110, 120, 130, 140),
          "field", ("vehicle.steering_gain",), 0.01),
    Sweep("obstacle", "sudden obstacle, visible from this many stopping distances", "", (1, 1.5, 2, 3, 5), "box", WAYS),
)  # fmt: skip
BY_NAME = {sweep.name: sweep for sweep in SWEEPS}


@dataclass(frozen=True)
class Box:
    """Position of a sudden obstacle and of its appearance: meters along and left of the centerline."""

    s: float
    offset: float
    sight: float


@dataclass(frozen=True)
class Case:
    """One race to drive."""

    sweep: Sweep
    value: float
    spec: str
    track: Track
    reverse: bool
    seed: int
    box: Box | None = None


@dataclass(frozen=True)
class Drive:
    """The result of a case. verdict: finished, passed, stopped, contact (with `what`: wall or obstacle), or the
    outcome.

    clearance [m]: to the obstacle, if there was one.
    """

    case: Case
    verdict: str
    laps: list[float]
    what: str | None = None
    s: float | None = None
    speed: float | None = None
    clearance: float | None = None

    @property
    def contact_free(self) -> bool:
        """Whether there was no contact."""
        return self.verdict != "contact"

    @property
    def finished(self) -> bool:
        """Whether all laps were driven, or the car passed the obstacle or stopped for it."""
        return self.verdict in ("finished", "passed", "stopped")


def chosen_sweeps(names: Sequence[str] | None) -> list[Sweep]:
    """The sweeps of these names; all for None. Raises InputError."""
    for name in names or ():
        if name not in BY_NAME:
            raise InputError(f"--sweep {name[:60]}: no such sweep; expected {', '.join(BY_NAME)}")
    return [sweep for sweep in SWEEPS if not names or sweep.name in names]


def stopping_distance(car: Car, speed: float, lateral: float) -> float:
    """Shortest distance [m] in which a car at `speed` [m/s] and lateral acceleration `lateral` [m/s^2] can stop.

    Two scan periods until a complete scan shows the obstacle, the delay of the speed command, full braking with the
    grip left by cornering and with load transfer, the settling of the speed loop, and 5 cm.
    """
    values = car.core.values()
    vehicle, rate = values["vehicle"], values["lidar"]["rate"]
    grip = vehicle["drive_grip"] * vehicle["friction"] * GRAVITY
    wanted = min(vehicle["brake_max"], math.sqrt(max(grip**2 - lateral**2, (0.3 * grip) ** 2)))
    wheelbase, share = vehicle["l_f"] + vehicle["l_r"], vehicle["drive_split"]
    shift = wanted / GRAVITY * vehicle["cg_height"]
    front = min(share * wanted, grip * (vehicle["l_r"] + shift) / wheelbase)
    braking = front + min((1.0 - share) * wanted, grip * (vehicle["l_f"] - shift) / wheelbase)
    tail = min(speed, braking / vehicle["speed_gain"])
    reaction = 2.0 / rate + vehicle["speed_delay"]
    return float(speed * reaction + (speed**2 - tail**2) / (2.0 * braking) + tail / vehicle["speed_gain"] + 0.05)


def boxes(reference: RaceResult, car: Car, count: int, value: float) -> Iterator[Box]:
    """Obstacles on the line of the last lap of `reference`, at `count` places and `BESIDE` it.

    They appear when the car's front is `value` times the stopping distance before them, at most the run-up.
    """
    path, track = reference.path, reference.track
    last = path["time"] >= reference.time - reference.laps[-1].time
    order = np.argsort(path["s"][last])
    s, offset, speed, rate = (path[name][last][order] for name in ("s", "lateral_offset", "speed", "yaw_rate"))

    def at(values: Any, where: float) -> float:
        return float(np.interp(where % track.length, s, values, period=track.length))

    def needed(where: float) -> float:
        """The longest stopping distance within one meter of the car's front, since the actual path is unknown."""
        near = np.arange(where - 1.4, where, 0.1)
        return max(stopping_distance(car, at(speed, x), abs(at(speed * rate, x))) for x in near)

    for place in (np.arange(count) + 0.5) * track.length / count:
        sight = 0.05
        while sight < value * needed(place - sight):
            sight += 0.05
        sight = min(sight, RUN_UP - 2.0)
        i = int(np.searchsorted(track.stations, place)) % len(track.centerline)
        for beside in BESIDE:
            wanted = at(offset, place) + beside
            inside = float(np.clip(wanted, 0.1 - track.width_right[i], track.width_left[i] - 0.1))
            yield Box(float(place), inside, sight)


class InterruptedRacesError(Exception):
    """The races were interrupted."""


@dataclass
class Robustness:
    """Races of one setup with the disturbances of the sweeps, on all cores. options: conditions of every race."""

    setup: Setup
    car: Car
    laps: int
    options: Mapping[str, float] = field(default_factory=dict)
    drives: list[Drive] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    _stop: threading.Event = field(default_factory=threading.Event)

    @property
    def true_car(self) -> Car:
        """The car with the conditions applied."""
        return under_conditions(self.car, self.options)

    def cases(
        self, sweeps: Iterable[Sweep], tracks: dict[str, Track], seeds: int, both: bool, places: int
    ) -> Iterator[Case]:
        """All cases; only the reference laps of obstacles are driven here. Raises InputError."""
        for sweep in sweeps:
            for spec, track in tracks.items():
                for reverse in (False, True) if both else (False,):
                    if sweep.kind == "box":
                        yield from self._box_cases(sweep, spec, track, reverse, seeds, places)
                        continue
                    for value in sweep.values:
                        joined = sweep.kind == "joints" and value > 0.0
                        cut = with_pipes(track, PIPE_LENGTH, [value]) if joined else track
                        for seed in range(1, seeds + 1):
                            yield Case(sweep, value, spec, cut, reverse, seed)

    def _box_cases(
        self, sweep: Sweep, spec: str, track: Track, reverse: bool, seeds: int, places: int
    ) -> Iterator[Case]:
        reference = race(track, self.setup, self.car, laps=2, reverse=reverse, options=self.options)
        if not reference.finished:
            self.notes.append(
                f"{spec}, {reference.direction}: no obstacles, the race without them ends in {reference.outcome}"
            )
            return
        for value in sweep.values:
            for box in boxes(reference, self.true_car, places, value):
                for seed in range(1, seeds + 1):
                    yield Case(sweep, value, spec, track, reverse, seed, box)

    def drive(self, cases: Iterable[Case], done: Callable[[Drive], object] | None = None) -> None:
        """Runs all cases; `done` is called in this thread after each. If interrupted, finished cases are kept."""
        pool = ThreadPoolExecutor(max_workers=os.cpu_count())
        try:
            for future in as_completed([pool.submit(self.race, case) for case in cases]):
                self.drives.append(future.result())
                if done:
                    done(self.drives[-1])
        finally:
            self._stop.set()
            pool.shutdown(wait=True, cancel_futures=True)

    def race(self, case: Case) -> Drive:
        """Runs one case."""
        if case.box:
            return self._race_to_box(case, case.box)
        result = race(
            case.track,
            self.setup,
            self.car,
            laps=self.laps,
            seed=case.seed,
            reverse=case.reverse,
            options={**self.options, **case.sweep.conditions(case.value)},
            on_progress=self._check_stop,
        )
        laps = [lap.time for lap in result.laps if not lap.standing] or [lap.time for lap in result.laps]
        return Drive(
            case,
            result.outcome,
            laps if result.finished else [],
            "wall" if result.contact else None,
            result.contact.s if result.contact else None,
        )

    def _race_to_box(self, case: Case, box: Box) -> Drive:
        """Drives from a run-up before the box to a point behind it, or to a stop before it."""
        track = case.track.reversed() if case.reverse else case.track
        options = {
            **self.options,
            "start_s": box.s - RUN_UP,
            "obstacle_at": RUN_UP,
            "obstacle_offset": box.offset,
            "obstacle_sight": box.sight,
            "stuck_time": STANDING,
        }
        racer = Racer(self.setup, self.car)
        running = start_race(track, racer, self.car, laps=2, seed=case.seed, options=options)
        end = (box.s + RUN_OUT) % track.length
        while running.advance(4):
            self._check_stop(running)
            if 0.0 <= (running.s - end) % track.length < RUN_OUT / 2 and running.time > 1.0:
                break
        found = running.result()
        contact, seen = found["contact"], found["obstacle"]
        verdict = {"running": "passed", "stuck": "stopped" if seen else "stuck"}.get(found["outcome"])
        if not seen:
            verdict = "before"
        elif box.sight < stopping_distance(self.true_car, seen.speed, abs(seen.speed * seen.yaw_rate)):
            verdict = "impossible"
        return Drive(
            case,
            verdict or found["outcome"],
            [],
            None if contact is None else "obstacle" if contact.obstacle else "wall",
            float(running.s),
            seen.speed if seen else None,
            seen.clearance if seen else None,
        )

    def _check_stop(self, _running: _core.Race) -> None:
        if self._stop.is_set():
            raise InterruptedRacesError

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap robustness --json`: rates and laps per sweep and value, per track and for all tracks."""
        sweeps = [sweep for sweep in SWEEPS if any(drive.case.sweep is sweep for drive in self.drives)]
        return {
            "setup": self.setup.name,
            "set": {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()},
            "car": self.car.name,
            "options": dict(self.options),
            "laps": self.laps,
            "notes": self.notes,
            "sweeps": [self._sweep_dict(sweep) for sweep in sweeps],
        }

    def _sweep_dict(self, sweep: Sweep) -> dict[str, Any]:
        drives = [drive for drive in self.drives if drive.case.sweep is sweep]
        specs = list(dict.fromkeys(drive.case.spec for drive in sorted(drives, key=lambda drive: drive.case.spec)))
        by_track = {spec: [drive for drive in drives if drive.case.spec == spec] for spec in specs}
        return {
            "name": sweep.name,
            "title": sweep.title,
            "unit": sweep.unit,
            "points": [_point(drives, sweep, value) for value in sweep.values],
            "tracks": {spec: [_point(own, sweep, value) for value in sweep.values] for spec, own in by_track.items()},
            "contacts": [_contact(drive) for drive in sorted(drives, key=_order) if not drive.contact_free],
        }


def _order(drive: Drive) -> tuple[Any, ...]:
    case = drive.case
    return case.sweep.values.index(case.value), case.spec, case.reverse, case.seed, case.box.s if case.box else 0.0


def _point(drives: list[Drive], sweep: Sweep, value: float) -> dict[str, Any]:
    """Rates at one value; `lap_ratio` is the median over tracks of the median lap over that at the first value.

    Obstacles that no driver could stop for (see `stopping_distance`) or that the car did not reach are excluded.
    """
    driven = [drive for drive in drives if drive.case.value == value]
    own = [drive for drive in driven if drive.verdict not in UNJUDGED]
    count = len(own)
    point: dict[str, Any] = {
        "value": value,
        "runs": count,
        "contact_free": sum(drive.contact_free for drive in own) / count if count else None,
        "finished": sum(drive.finished for drive in own) / count if count else None,
    }
    if sweep.kind == "box":
        for verdict in ("passed", "stopped"):
            point[verdict] = sum(drive.verdict == verdict for drive in own) / count if count else None
        for verdict in UNJUDGED:
            point[verdict] = sum(drive.verdict == verdict for drive in driven)
        return point
    calm = _median_laps(drives, sweep.values[0])
    here = _median_laps(own, value)
    ratios = [here[key] / calm[key] for key in here if key in calm]
    point["lap_ratio"] = statistics.median(ratios) if ratios else None
    point["lap"] = next(iter(here.values())) if len(here) == 1 else None
    return point


def _median_laps(drives: list[Drive], value: float) -> dict[str, float]:
    """Median lap [s] by track, if any race finished."""
    laps: dict[str, list[float]] = {}
    for drive in drives:
        if drive.case.value == value:
            laps.setdefault(drive.case.spec, []).extend(drive.laps)
    return {spec: statistics.median(times) for spec, times in laps.items() if times}


def _contact(drive: Drive) -> dict[str, Any]:
    case = drive.case
    entry: dict[str, Any] = {
        "track": case.spec,
        "direction": "reverse" if case.reverse else "forward",
        "seed": case.seed,
        "value": case.value,
        "touched": drive.what,
        "s": drive.s,
    }
    if case.box:
        entry["obstacle"] = {"s": case.box.s, "offset": case.box.offset, "sight": case.box.sight}
        entry["speed"] = drive.speed
    return entry
