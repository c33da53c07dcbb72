"""Races of one car with one driver on one track."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap._core import Contact, Lap, ObstacleSeen
from firstlap.common.errors import InputError
from firstlap.common.version import __version__
from firstlap.config.car_file import CAR_FIELDS, Car, load_car
from firstlap.config.driver_kind import (
    CoreHandle,
    Handle,
    Preparation,
    ProgressCallback,
    SetsStart,
    UsesTruePose,
    driver_kind,
)
from firstlap.config.parameters import Field, FieldTable
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.perception.scan import judge
from firstlap.sim.lidar import core_track
from firstlap.tracks.track import Track

OPTION_FIELDS = FieldTable([*_core.RaceOptions.fields(), *_core.Car.fields()])
"""Conditions of a race: how it is run, and properties of the car that the driver does not know."""
OPTIONS = "race options"
"""Name of the conditions in messages."""
SCANS_PER_CALLBACK = 40
OF_THE_CORE = ("outcome", "time", "distance", "laps", "contact", "compute_times", "path", "skipped_scans", "obstacle")
"""Fields that a `RaceResult` copies from the core's result."""


@dataclass(frozen=True)
class Ending:
    """Why the race ended, according to the driver.

    status: of the driver's last step (`Status` in cpp/firstlap). scan_fault, scan_reason: result of the check of the
    last scan; 'none' and '' if it was valid.
    """

    status: str
    scan_fault: str
    scan_reason: str

    @property
    def said(self) -> str:
        """As text."""
        return f"last status {self.status}" + (f"; last scan: {self.scan_reason}" if self.scan_reason else "")


@dataclass(frozen=True)
class RaceResult:
    """The result of a race.

    outcome: finished, contact, stuck, timeout, wrong_way, or running when it was interrupted.
    options: conditions that were set, of the table `OPTION_FIELDS`, without laps and seed.
    path: columns, one entry per scan, map frame and SI; see docs/results-format.md.
    compute_times: (steps,) microseconds of each driver step, by its thread's CPU clock.
    skipped_scans: number of scans that arrived while the driver was busy and were replaced by the next one.
    latency: how the compute time delayed the commands. preparation: done before the race.
    ending: why a race did not finish; None before the first step.
    """

    track: Track
    setup: Setup
    car: Car
    seed: int
    direction: str
    outcome: str
    time: float
    distance: float
    laps: list[Lap]
    contact: Contact | None
    compute_times: npt.NDArray[np.float32]
    path: dict[str, npt.NDArray[Any]]
    options: Mapping[str, float] = field(default_factory=dict)
    skipped_scans: int = 0
    latency: str = "none"
    obstacle: ObstacleSeen | None = None
    preparation: Preparation = field(default_factory=Preparation)
    ending: Ending | None = None

    @property
    def finished(self) -> bool:
        """Whether all laps were driven."""
        return self.outcome == "finished"

    @property
    def best(self) -> float | None:
        """Shortest lap time [s]; None without a complete lap."""
        return min((lap.time for lap in self.laps), default=None)

    @property
    def compute(self) -> dict[str, float | None]:
        """p50, p99 and max of a step in microseconds."""
        times = self.compute_times
        if len(times) == 0:
            return {"p50": None, "p99": None, "max": None}
        p50, p99 = np.percentile(times, [50, 99])
        return {"p50": round(float(p50), 2), "p99": round(float(p99), 2), "max": round(float(times.max()), 2)}

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap race --json`. The same seed gives the same result, except for compute times."""
        changed = {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()}
        return {
            "version": __version__,
            "track": self.track.name,
            "track_length": round(self.track.length, 6),
            "direction": self.direction,
            "driver": self.setup.driver,
            "setup": self.setup.name,
            "set": changed,
            "car": self.car.name,
            "options": dict(self.options),
            "seed": self.seed,
            "outcome": self.outcome,
            "laps": [lap.to_dict() for lap in self.laps],
            "best": self.best,
            "contact": self.contact.to_dict() if self.contact else None,
            "ending": asdict(self.ending) if self.ending else None,
            "latency": self.latency,
            "skipped_scans": self.skipped_scans,
            "compute": self.compute,
            **({"preparation": self.preparation.to_dict()} if driver_kind(self.setup.driver).needs_map else {}),
        }

    def plot(self, path: str | Path) -> None:
        """Writes a plot: the driven line colored by speed on the track, with the lap times."""
        from firstlap.plots.race import plot_race

        plot_race(self, path)


def latency_options(latency: str) -> dict[str, float]:
    """Race options for measured, fixed:MS or none. Raises InputError."""
    if latency == "none":
        return {}
    if latency == "measured":
        return {"measure_latency": True}
    word, colon, number = latency.partition(":")
    longest = 1000.0 * OPTION_FIELDS.find("compute_latency", "latency").max
    try:
        milliseconds = float(number)
    except ValueError:
        milliseconds = -1.0
    if word != "fixed" or not colon or not 0.0 <= milliseconds <= longest:
        raise InputError(f"latency '{latency[:40]}': expected measured, none, or fixed:MS with 0 to {longest:g} ms")
    return {"compute_latency": milliseconds / 1000.0}


def tell_start(driver: Handle, track: Track, options: Mapping[str, float] | None) -> None:
    """Tells the driver its approximate start position, if it needs it."""
    if isinstance(driver, SetsStart):
        given = {OPTION_FIELDS.find(name, OPTIONS).key: value for name, value in (options or {}).items()}
        driver.set_start(float(given.get("race.start_s", 0.0)) / track.length)


def option_name(field: Field) -> str:
    """The name of a condition in results: for options of the race the name, for fields of the car section.name."""
    return field.key if field.section in CAR_FIELDS.sections else field.name


def under_conditions(car: Car, options: Mapping[str, float] | None, where: str = OPTIONS) -> Car:
    """The car with the car fields in `options` applied. where: name of the options in messages. Raises InputError, also
    if they contradict each other or the car."""
    given = {OPTION_FIELDS.find(name, where): value for name, value in (options or {}).items()}
    changes = {entry: value for entry, value in given.items() if entry.section in CAR_FIELDS.sections}
    if not changes:
        return car
    core = _core.Car(car.core)
    for entry, value in changes.items():
        core.set(entry.section, entry.name, OPTION_FIELDS.check(entry, value, where))
    try:
        core.validate()
    except ValueError as error:
        raise InputError(f"{where} {_assignments(options)}: {error}") from None
    return Car(car.name, core, car.source)


def _assignments(options: Mapping[str, float] | None) -> str:
    return ", ".join(f"{name}={value:g}" for name, value in (options or {}).items())


def start_race(
    track: Track,
    driver: Handle,
    car: Car,
    *,
    laps: int = 3,
    seed: int = 1,
    options: Mapping[str, float] | None = None,
) -> _core.Race:
    """A race that has not begun, for stepping. The driver knows `car` without `options`.

    Raises InputError if it cannot begin."""
    core_options = _core.RaceOptions()
    for name, value in {"laps": laps, **(options or {})}.items():
        entry = OPTION_FIELDS.find(name, OPTIONS)
        if entry.section not in CAR_FIELDS.sections:
            core_options.set(entry.section, entry.name, OPTION_FIELDS.check(entry, value, OPTIONS))
    if not 0 <= seed < 2**64:
        raise InputError(f"seed is {seed}; allowed: 0 to 2^64 - 1")
    core_options.seed = seed
    tell_start(driver, track, options)
    conditioned = under_conditions(car, options)
    try:
        return _core.Race(core_track(track), conditioned.core, driver.core, core_options)
    except ValueError as error:
        under = f" with {OPTIONS} {_assignments(options)}" if options else ""
        raise InputError(f"{track.name}{under}: {error}") from None


def race(
    track: Track,
    setup: str | Setup | None = None,
    car: str | Car = "default",
    *,
    driver: str | None = None,
    laps: int = 3,
    seed: int = 1,
    reverse: bool = False,
    latency: str = "none",
    preparation: Preparation | None = None,
    options: Mapping[str, float] | None = None,
    on_progress: Callable[[_core.Race], object] | None = None,
    preparing: ProgressCallback | None = None,
    record: str | Path | None = None,
) -> RaceResult:
    """Races until the laps are driven, or until a contact, a standstill, a timeout or driving the wrong way.

    setup, car: a name, a file, or a loaded object. driver: its name; default: the setup's, or local. seed: of all
    randomness. latency: measured, fixed:MS or none, how the driver's compute time delays its commands. preparation: of
    a driver that needs a map; default: it is prepared here. options: conditions from the table `OPTION_FIELDS`, such as
    mu_scale or sensors.speed_scale_error. on_progress: called about once per simulated second with the race; an
    exception from it ends the race. preparing: progress callback of the preparation. record: an .mcap file for the log,
    see docs/recordings.md. Raises InputError.
    """
    setup = choose_setup(driver, setup)
    kind = driver_kind(setup.driver)
    delay = latency_options(latency)
    car = car if isinstance(car, Car) else load_car(car)
    if reverse:
        track = track.reversed()
    if preparation is None:
        preparation = kind.prepare(track, setup, car, seed, preparing)
    handle = kind.make(setup.params(car.core), car, preparation)
    logged = None if record is None else _core.LoggedDriver(handle.core)
    starter = handle if logged is None else CoreHandle(logged)
    tell_start(handle, track, options)
    running = start_race(track, starter, car, laps=laps, seed=seed, options={**delay, **(options or {})})
    with _true_pose(handle, running, track):
        if record is not None and logged is not None:
            from firstlap.recordings.race_log import drive_and_log, race_about

            what = f"{track.name}{', reverse' if reverse else ''}"
            drive_and_log(running, logged, race_about(running, setup, car, what, seed), record, on_progress)
        while running.advance(SCANS_PER_CALLBACK):
            if on_progress:
                on_progress(running)
    found = running.result()
    return RaceResult(
        track=track,
        setup=setup,
        car=car,
        seed=seed,
        direction="reverse" if reverse else "forward",
        options=dict(options or {}),
        latency=latency,
        preparation=preparation,
        ending=None if found["outcome"] == "finished" else _ending(running, car, found["path"]["status"]),
        **{name: found[name] for name in OF_THE_CORE},
    )


@contextmanager
def _true_pose(handle: Handle, running: _core.Race, track: Track) -> Iterator[None]:
    """While the race runs, a driver that can use its true pose has it."""
    if not isinstance(handle, UsesTruePose):
        yield
        return
    try:
        handle.use_true_pose(running, track)
        yield
    finally:
        handle.use_true_pose(None, track)


def _ending(running: _core.Race, car: Car, statuses: npt.NDArray[Any]) -> Ending | None:
    if not len(statuses):
        return None
    judged = judge(running.scan(), 1.0 / float(car.core.get("lidar", "rate")))  # type: ignore[arg-type]
    return Ending(_core.STATUSES[int(statuses[-1])], judged.fault, judged.reason)
