"""Candidates: their races and their cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS, Car
from firstlap.config.parameters import Values
from firstlap.config.setup_file import Setup
from firstlap.drivers import driver_kind
from firstlap.sim.race import RaceResult, race
from firstlap.tracks.track import Track
from firstlap.tuning.variation import Conditions, changed_car, race_options

RaceCallback = Callable[[_core.Race], object]
FAILURES_TO_END = 2
RACES_TO_END = 2


@dataclass(frozen=True)
class Problem:
    """The races of every candidate of a search; plain data, so that it can be sent to other processes.

    track: in the direction of travel. car: {section: {name: value}}. spread, margin and hopeless: as in the field
    table. slowest: mean speed [m/s] below which a race times out; 0: the race's default. patient: no candidate is
    stopped early.
    """

    track: Track
    driver: str
    car_name: str
    car: dict[str, dict[str, Any]]
    conditions: tuple[Conditions, ...]
    spread: dict[str, float]
    laps: int
    margin: float
    hopeless: float
    slowest: float = 0.0
    patient: bool = False


@dataclass(frozen=True)
class Verdict:
    """The result of one candidate.

    laps: mean flying lap [s] per race, None if not finished, in the order of the conditions; fewer than those if it was
    stopped early. progress: share of each race that was driven. clearances: smallest of each race [m]. ended: why it
    was stopped early, or empty. driven: laps simulated, including partial ones.
    """

    laps: list[float | None]
    progress: list[float]
    clearances: list[float]
    margin: float
    outcomes: list[str] = field(default_factory=list)
    ended: str = ""
    driven: float = 0.0

    @property
    def raced(self) -> int:
        """Number of races driven."""
        return len(self.laps)

    @property
    def clearance(self) -> float:
        """Smallest clearance of all races [m]; 0 with a contact."""
        return min(self.clearances, default=0.0)

    @property
    def failed(self) -> int:
        """Number of races not finished."""
        return sum(lap is None for lap in self.laps)

    @property
    def lap(self) -> float | None:
        """Mean flying lap over the finished races [s]."""
        finished = [lap for lap in self.laps if lap is not None]
        return sum(finished) / len(finished) if finished else None

    @property
    def holds(self) -> bool:
        """Whether it is reliable: all races were driven and finished, and the margin was kept."""
        return self.raced > 0 and self.failed == 0 and self.clearance >= self.margin and not self.ended

    def cost(self, reference: float) -> float:
        """Cost to minimize [s]. A reliable lap costs less than `slowest` reference laps, a violated margin 2 to 3, a
        failed race 3 to 4, so that no lap time compensates for either (Deb 2000)."""
        if self.raced == 0:
            return 5.0 * reference
        if self.failed:
            return reference * (4.0 - sum(self.progress) / self.raced)
        if self.clearance < self.margin:
            return reference * (2.0 + (1.0 - self.clearance / self.margin))
        return min(self.lap or 2.0 * reference, 2.0 * reference)

    def to_dict(self) -> dict[str, Any]:
        """As stored in the study file."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Verdict:
        """The inverse of `to_dict`. Raises TypeError or ValueError for invalid data."""
        verdict = cls(**data)
        numbers = [lap for lap in verdict.laps if lap is not None]
        numbers += [*verdict.progress, *verdict.clearances, verdict.margin, verdict.driven]
        if not all(isinstance(number, int | float) for number in numbers):
            raise TypeError("a number of its result is not a number")
        if not all(isinstance(text, str) for text in (*verdict.outcomes, verdict.ended)):
            raise TypeError("a text of its result is not text")
        if len(verdict.progress) != len(verdict.laps) or len(verdict.clearances) != len(verdict.laps):
            raise ValueError("its result has different numbers of laps and races")
        return verdict


@lru_cache(maxsize=4)
def _car_of(name: str, items: tuple[tuple[str, str, Any], ...]) -> Car:
    core = _core.Car()
    for section, entry, value in items:
        core.set(section, entry, value)
    return Car(name, core)


def plain_car(car: Car) -> dict[str, dict[str, Any]]:
    """The car as plain data."""
    return {section: dict(values) for section, values in car.core.values().items()}


def car_of(problem: Problem) -> Car:
    """The problem's car for the simulator."""
    items = tuple((row.section, row.name, problem.car[row.section][row.name]) for row in CAR_FIELDS.fields)
    return _car_of(problem.car_name, items)


def race_one(
    problem: Problem, setup: Setup, conditions: Conditions, preparation: Any, on_progress: RaceCallback | None
) -> RaceResult:
    """One race of a candidate, whose driver knows the nominal car."""
    car = car_of(problem)
    options: dict[str, float] = {"record_path": False, **race_options(problem.spread, conditions)}
    if problem.slowest > 0.0:
        options["timeout_speed"] = problem.slowest
    return race(
        problem.track,
        setup.with_car_values(car.core),
        changed_car(car, problem.spread, conditions),
        laps=problem.laps,
        seed=conditions.seed,
        options=options,
        preparation=preparation,
        on_progress=on_progress,
    )


def judge(
    problem: Problem, given: Values, best: Sequence[float | None] | None = None, on_progress: RaceCallback | None = None
) -> Verdict:
    """Races a candidate under all conditions, or until it is hopeless.

    given: its setup. best: laps per race of the best reliable candidate so far; a candidate that is slower by more than
    the share `hopeless`, or that failed twice, is stopped early.
    """
    setup = Setup("candidate", dict(given), driver=problem.driver)
    try:
        setup.validate("candidate")
    except InputError:
        return Verdict([], [], [], problem.margin, ended="contradicts itself")
    preparation = driver_kind(problem.driver).prepare(problem.track, setup, car_of(problem), 0, None)
    laps: list[float | None] = []
    progress: list[float] = []
    outcomes: list[str] = []
    clearances: list[float] = []
    driven = 0.0
    ended = ""
    for conditions in problem.conditions:
        result = race_one(problem, setup, conditions, preparation, on_progress)
        flying = [lap.time for lap in result.laps if not lap.standing]
        laps.append(sum(flying) / len(flying) if result.finished and flying else None)
        done = 1.0 if result.finished else min(result.distance / (problem.track.length * problem.laps), 1.0)
        progress.append(done)
        outcomes.append(result.outcome)
        driven += done * problem.laps
        clearances.append(0.0 if result.contact else min((lap.min_clearance for lap in result.laps), default=0.0))
        ended = _hopeless(problem, laps, best) if len(laps) < len(problem.conditions) else ""
        if ended:
            break
    return Verdict(laps, progress, clearances, problem.margin, outcomes, ended, driven)


def _hopeless(problem: Problem, laps: list[float | None], best: Sequence[float | None] | None) -> str:
    failed = sum(lap is None for lap in laps)
    if problem.patient:
        return ""
    if failed >= FAILURES_TO_END:
        return "failed twice"
    if best is None or failed or len(laps) < RACES_TO_END:
        return ""
    pairs = [(mine, theirs) for mine, theirs in zip(laps, best, strict=False) if mine and theirs]
    slower = sum(mine for mine, _ in pairs) / sum(theirs for _, theirs in pairs) - 1.0
    return "too slow" if slower > problem.hopeless else ""
