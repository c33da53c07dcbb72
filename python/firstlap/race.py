"""Races: one car, one track, one driver, some laps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.car_file import Car, load_car
from firstlap.errors import InputError
from firstlap.parameters import FieldTable
from firstlap.racer import Racer
from firstlap.setup_file import Setup, load_setup
from firstlap.simulate import core_track
from firstlap.tracks.track import Track

OPTION_FIELDS = FieldTable(_core.RaceOptions.fields())
SCANS_PER_LOOK = 40


@dataclass(frozen=True)
class Lap:
    """time [s] interpolated at the line, distance [m], speeds [m/s], min_clearance and rms_offset [m]."""

    time: float
    distance: float
    mean_speed: float
    max_speed: float
    min_clearance: float
    rms_offset: float
    standing: bool


@dataclass(frozen=True)
class Contact:
    """When [s] and where (map frame, s along the centerline) [m] the car touched a wall or the sudden obstacle."""

    time: float
    x: float
    y: float
    s: float
    obstacle: bool = False


@dataclass(frozen=True)
class ObstacleSeen:
    """When [s] the sudden obstacle appeared, its middle (map frame) [m, rad], the car's speed [m/s] and yaw rate
    [rad/s] then, and the smallest clearance between the two since [m]."""

    time: float
    x: float
    y: float
    yaw: float
    speed: float
    yaw_rate: float
    clearance: float


@dataclass(frozen=True)
class RaceResult:
    """What a race leaves behind.

    outcome: finished, contact, stuck, timeout, wrong_way, or running when it was interrupted.
    path: columns, one entry per scan, map frame and SI: time, x, y, yaw, speed, s, lateral_offset, ...
    compute_times: (steps,) microseconds of each driver step, by the wall clock.
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
    obstacle: ObstacleSeen | None = None

    @property
    def finished(self) -> bool:
        """Whether all laps were driven."""
        return self.outcome == "finished"

    @property
    def best(self) -> float | None:
        """Shortest lap time [s], None without a complete lap."""
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
        """As `firstlap race --json` prints it. The same seed gives the same, compute aside."""
        changed = {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()}
        return {
            "version": version("firstlap"),
            "track": self.track.name,
            "track_length": round(self.track.length, 6),
            "direction": self.direction,
            "driver": "firstlap",
            "setup": self.setup.name,
            "set": changed,
            "car": self.car.name,
            "seed": self.seed,
            "outcome": self.outcome,
            "laps": [asdict(lap) for lap in self.laps],
            "best": self.best,
            "contact": asdict(self.contact) if self.contact else None,
            "compute": self.compute,
        }

    def plot(self, path: str | Path) -> None:
        """Writes a picture: the driven line coloured by speed on the track, with the lap times."""
        from firstlap.plot import plot_race

        plot_race(self, path)


def start_race(
    track: Track,
    racer: Racer,
    car: Car,
    *,
    laps: int = 3,
    seed: int = 1,
    options: Mapping[str, float] | None = None,
) -> _core.Race:
    """A race that has not begun, for stepping. Raises InputError where it cannot begin."""
    core_options = _core.RaceOptions()
    for name, value in {"laps": laps, **(options or {})}.items():
        field = OPTION_FIELDS.find(name, "race options")
        core_options.set(field.section, field.name, OPTION_FIELDS.check(field, value, "race options"))
    if not 0 <= seed < 2**64:
        raise InputError(f"seed is {seed}, outside of what is allowed: 0 to 2^64 - 1")
    core_options.seed = seed
    try:
        return _core.Race(core_track(track), car.core, racer.core, core_options)
    except ValueError as error:
        raise InputError(f"{track.name}: {error}") from None


def race(
    track: Track,
    setup: str | Setup = "sure",
    car: str | Car = "default",
    *,
    laps: int = 3,
    seed: int = 1,
    reverse: bool = False,
    options: Mapping[str, float] | None = None,
    look: Callable[[_core.Race], object] | None = None,
) -> RaceResult:
    """Races until the laps are driven, or the car touches a wall, stands, or turns back.

    setup, car: a name, a file, or a loaded one. seed: of everything random. options: of the field table
    `RaceOptions`, such as mu_scale or compute_latency. look: called about once a simulated second with the race so
    far; an exception from it ends the race. Raises InputError.
    """
    setup = setup if isinstance(setup, Setup) else load_setup(setup)
    car = car if isinstance(car, Car) else load_car(car)
    if reverse:
        track = track.reversed()
    running = start_race(track, Racer(setup, car), car, laps=laps, seed=seed, options=options)
    while running.advance(SCANS_PER_LOOK):
        if look:
            look(running)
    found = running.result()
    return RaceResult(
        track=track,
        setup=setup,
        car=car,
        seed=seed,
        direction="reverse" if reverse else "forward",
        outcome=found["outcome"],
        time=found["time"],
        distance=found["distance"],
        laps=[Lap(**lap) for lap in found["laps"]],
        contact=Contact(**found["contact"]) if found["contact"] else None,
        compute_times=found["compute_times"],
        path=found["path"],
        obstacle=ObstacleSeen(**found["obstacle"]) if found["obstacle"] else None,
    )
