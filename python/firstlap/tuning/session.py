"""One tuning session from the user's options: problem, starting setups, search space, and study attributes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from firstlap.common.errors import InputError
from firstlap.common.text import printable, short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import BASE, LOCAL, Setup, choose_setup, list_setups, load_setup
from firstlap.tracks.track import Track
from firstlap.tuning.candidate import Problem, plain_car
from firstlap.tuning.space import Space, make_space
from firstlap.tuning.study import study_names, track_digest
from firstlap.tuning.variation import SPREAD_NAMES, corners

SEARCHED = ("laps", "margin", "hopeless", "slowest")
"""Rows of the evaluation table that affect the search; the others apply after it."""


@dataclass(frozen=True)
class Session:
    """The options of a session. track: in the direction of travel; reverse: whether that is the opposite direction."""

    spec: str
    track: Track
    reverse: bool
    car: Car
    starts: list[Setup]
    space: Space
    judge: dict[str, float]
    seeds: int
    seed: int
    population: int | None

    @property
    def driver(self) -> str:
        """The driver whose setup is tuned."""
        return self.starts[0].driver

    @property
    def tuned_for(self) -> str:
        """What the setups of this session are tuned for, as their files say it."""
        return printable(short_name(self.spec)) + (", reverse" if self.reverse else "")

    @property
    def spread(self) -> dict[str, float]:
        """The rows of the evaluation table that vary from race to race."""
        return {name: self.judge[name] for name in SPREAD_NAMES}

    def problem(self) -> Problem:
        """The races of a candidate."""
        return Problem(
            track=self.track,
            driver=self.driver,
            car_name=self.car.name,
            car=plain_car(self.car),
            conditions=tuple(corners(self.seeds, self.seed)),
            spread=self.spread,
            laps=int(self.judge["laps"]),
            margin=self.judge["margin"],
            hopeless=self.judge["hopeless"],
        )

    def about(self) -> dict[str, Any]:
        """The attributes that identify a search; stored in the study."""
        return {
            "track": self.spec,
            "track_digest": track_digest(self.track),
            "direction": "reverse" if self.reverse else "forward",
            "driver": self.driver,
            "car": plain_car(self.car),
            "starts": {
                start.name: {f"{section}.{name}": value for (section, name), value in start.given.items()}
                for start in self.starts
            },
            "space": self.space.to_dict(),
            "judge": {name: self.judge[name] for name in (*SPREAD_NAMES, *SEARCHED)},
            "seeds": self.seeds,
            "seed": self.seed,
            "population": self.population,
            "version": __version__,
        }


def make_session(
    spec: str,
    track: Track,
    *,
    driver: str | None,
    start: str | None,
    others: str | None = None,
    car: Car,
    judge: dict[str, float],
    seeds: int = 8,
    seed: int = 1,
    reverse: bool = False,
    only: str | None = None,
    fix: str | None = None,
    population: int | None = None,
) -> Session:
    """start: the setup to start from and to compare with; default: base, or the driver's own.

    others: further starting setups, comma-separated, or `none`; default: our own of the same driver.
    Raises InputError.
    """
    driver_kind(driver or LOCAL)
    if start is None and (driver or LOCAL) == LOCAL:
        start = BASE
    first = choose_setup(driver, start)
    starts = starts_of(first, others)
    space = make_space(starts, only, fix)
    if only is not None or fix is not None:
        starts = [first, *(_only_these(first, other, space) for other in starts[1:])]
    return Session(
        spec=spec,
        track=track.reversed() if reverse else track,
        reverse=reverse,
        car=car,
        starts=starts,
        space=space,
        judge=judge,
        seeds=seeds,
        seed=seed,
        population=population,
    )


def _only_these(first: Setup, other: Setup, space: Space) -> Setup:
    """The first starting setup with another's values for the tuned parameters."""
    values = {(a.field.section, a.field.name): other.get(a.field.key) for a in space.axes}
    return replace(first, name=f"{first.name} with {other.name}", given={**first.given, **values})


def starts_of(first: Setup, others: str | None = None) -> list[Setup]:
    """The given setup, then the others, or our own of the same driver; the search begins at the best of them."""
    names = list_setups(first.driver) if others is None else _named(others)
    found = [load_setup(name, first.driver) for name in names]
    return [first, *(setup for setup in found if setup.given != first.given)]


def _named(others: str) -> list[str]:
    names = [name.strip() for name in others.split(",") if name.strip()]
    if not names:
        raise InputError("--starts: expected comma-separated setups, for example sure,race, or none")
    return [] if names == ["none"] else names


def new_name(path: Path, track: Track, driver: str, reverse: bool) -> str:
    """A name not yet used in the study file: arena-1, arena-2, ... Raises InputError."""
    stem = Path(track.name).stem + ("-reverse" if reverse else "") + ("" if driver == LOCAL else f"-{driver}")
    taken = set(study_names(path))
    return next(f"{stem}-{number}" for number in range(1, 1_000_000) if f"{stem}-{number}" not in taken)


def check_name(name: str) -> str:
    """Checks the name of a study, which is also used in file names. Raises InputError."""
    if not name or len(name) > 80 or any(not (c.isalnum() or c in "-_.") for c in name) or name.startswith("."):
        raise InputError(f"--name {name[:60]!r}: expected letters, digits, - and _")
    return name
