"""The search: CMA-ES over the unit cube, generation by generation.

A generation is sampled as a whole, raced in any order, and returned to the optimizer as a whole, sorted by number, so
the result does not depend on the number of workers. An interrupted study is resumed by repeating the search from the
beginning; results of earlier races are taken from the study file.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.parameters import Values
from firstlap.config.setup_file import Setup
from firstlap.tuning.candidate import Problem, Verdict
from firstlap.tuning.pool import Pool, race_all
from firstlap.tuning.space import Point, Space
from firstlap.tuning.study import Study, Trial

SIGMA = 0.12
SIGMA_MIN = 0.03
STALE = 3
PROBES = 6
MOST_RESERVED = 0.5


@dataclass(frozen=True)
class Budget:
    """Maximum number of trials, or maximum duration of the search in seconds."""

    trials: int | None = None
    seconds: float | None = None

    def __str__(self) -> str:
        return f"{self.trials} trials" if self.trials is not None else f"{self.seconds:g} s"


def parse_budget(text: str) -> Budget:
    """Parses 3m, 90s, 1h or a number of trials. Raises InputError."""
    unit = {"s": 1.0, "m": 60.0, "h": 3600.0}.get(text[-1:].lower())
    try:
        number = float(text[:-1] if unit else text)
    except ValueError:
        number = -1.0
    if not 0.0 < number < 1e9 or (unit is None and number != int(number)):
        raise InputError(f"--budget {text[:40]}: expected a time like 3m, 90s or 1h, or a number of trials from 1")
    return Budget(seconds=number * unit) if unit else Budget(trials=int(number))


class Search:
    """One search. trunk: the best starting setup, which provides all values outside of the space. compared: the first
    starting setup that finishes; reference: its lap [s]. slowest: timeout of a lap, as a multiple of `reference`.
    laps_after: number of laps after the search, within the same time budget.
    """

    def __init__(
        self,
        problem: Problem,
        starts: Sequence[Setup],
        space: Space,
        study: Study,
        pool: Pool,
        seed: int,
        population: int | None = None,
        slowest: float = 1.5,
    ) -> None:
        self.problem = problem
        self.starts = list(starts)
        self.space = space
        self.study = study
        self.pool = pool
        self.seed = seed
        self.population = population or default_population(len(space.axes))
        self.trunk: Setup = self.starts[0]
        self.compared: Setup = self.starts[0]
        self.reference = 0.0
        self.slowest = slowest
        self.laps_after = 0.0
        self.done: Callable[[Trial], object] = lambda _trial: None
        self.cpu_seconds = 0.0
        self._began = time.monotonic()
        self._seconds_before = study.seconds

    @property
    def seconds(self) -> float:
        """Duration of the search so far [s], including before a resume."""
        return self._seconds_before + time.monotonic() - self._began

    @property
    def best(self) -> Trial | None:
        """The reliable trial of lowest cost."""
        return min((t for t in self.study.ordered if t.verdict.holds), key=lambda t: (t.cost, t.number), default=None)

    def run(self, budget: Budget) -> None:
        """Races until the budget is used. Raises InputError if no starting setup finishes, PoolGoneError."""
        before = time.process_time()
        self._run(budget)
        self.cpu_seconds = time.process_time() - before

    def _run(self, budget: Budget) -> None:
        self._race_starts(budget)
        number = len(self.starts)
        probes = self._probes()
        if probes:
            left = self._left(budget, number, sum(len(points) for points in probes.values()))
            trials = self._race([setup for points in probes.values() for setup in points][:left], number)
            number += len(trials)
            self.trunk = self._best_neighborhood(probes, trials)
        round_, begun = 0, number
        optimizer = self._optimizer(round_, number)
        while left := self._left(budget, number, self.population):
            asked = [optimizer.ask() for _ in range(self.population)]
            trials = self._race([self._setup(x) for x in asked[:left]], number)
            number += left
            if left < self.population:
                return
            optimizer.tell([(x, trial.cost) for x, trial in zip(asked, trials, strict=True)])
            if optimizer.should_stop() or self._stale(number, begun):
                round_, begun = round_ + 1, number
                optimizer = self._optimizer(round_, number)

    def _stale(self, number: int, begun: int) -> bool:
        """Whether the last generations of this restart found no better reliable setup."""
        best = self._best_before(number)
        last = max(best.number + 1 if best else 0, begun)
        return number - last >= STALE * self.population

    def _best_before(self, number: int) -> Trial | None:
        held = [t for t in self.study.ordered if t.verdict.holds and t.number < number]
        return min(held, key=lambda t: (t.cost, t.number), default=None)

    def _probes(self) -> dict[int, list[Setup]]:
        """{start: setups near it} for every starting setup that finished; empty if there is only one."""
        whole = [i for i in range(len(self.starts)) if i in self.study.trials and self.study.trials[i].verdict.lap]
        whole = [i for i in whole if not self.study.trials[i].verdict.failed]
        if len(whole) < 2:
            return {}
        rng = np.random.default_rng(self.seed)
        found = {}
        for index in whole:
            middle = self.space.to_unit(self.starts[index])
            points = np.clip(middle + SIGMA * rng.standard_normal((PROBES, len(middle))), 0.0, 1.0)
            found[index] = [self._setup(point, self.starts[index]) for point in points]
        return found

    def _best_neighborhood(self, probes: dict[int, list[Setup]], trials: Sequence[Trial]) -> Setup:
        """The starting setup whose neighbors have the best median: a fast isolated setup is a poor start."""
        costs = [trial.cost for trial in trials]
        middle = {}
        for index, points in probes.items():
            mine, costs = costs[: len(points)], costs[len(points) :]
            middle[index] = float(np.median(mine)) if mine else np.inf
        best = min(middle, key=lambda index: (middle[index], index))
        return self.starts[best] if np.isfinite(middle[best]) else self.trunk

    def _left(self, budget: Budget, number: int, wanted: int) -> int:
        """How many of the next trials the budget still allows."""
        if self._out_of_time(budget, number):
            return 0
        return wanted if budget.trials is None else max(min(budget.trials - number, wanted), 0)

    def _out_of_time(self, budget: Budget, number: int) -> bool:
        """Whether the next generation would exceed the budget; trials already in the study cost nothing.

        Time is reserved for the laps of the selection, at the rate so far, but at most half of the budget.
        """
        if budget.seconds is None or number in self.study.trials:
            return False
        trials = self.study.ordered
        generation = self.seconds / max(len(trials), 1) * self.population
        per_lap = self.seconds / max(sum(trial.verdict.driven for trial in trials), 1.0)
        left = budget.seconds - min(self.laps_after * per_lap, MOST_RESERVED * budget.seconds)
        return self.seconds + 0.5 * generation > left

    def _race_starts(self, budget: Budget) -> None:
        trials = self._race(self.starts[: budget.trials], 0)
        whole = [trial for trial in trials if trial.verdict.failed == 0 and trial.verdict.lap]
        if not whole:
            raise InputError(f"{self.problem.track.name}: no starting setup finishes it; {_why(trials)}")
        first = next(trial for trial in whole)
        self.compared = self.starts[first.number]
        self.reference = first.verdict.lap or 0.0
        self.problem = replace(self.problem, slowest=self.problem.track.length / (self.slowest * self.reference))
        best = min(whole, key=lambda trial: (self._cost(trial.verdict), trial.number))
        self.trunk = self.starts[best.number]

    def _optimizer(self, round_: int, number: int) -> Any:
        """Starts at the best starting setup; restarts use the best setup so far, a smaller spread and another seed."""
        import cmaes

        best = self._best_before(number)
        mean = self.space.to_unit(replace(self.trunk, given=best.given) if round_ and best else self.trunk)
        size = len(self.space.axes)
        return cmaes.CMA(
            mean=np.clip(mean, 0.0, 1.0),
            sigma=max(SIGMA * 0.5**round_, SIGMA_MIN),
            bounds=np.tile([0.0, 1.0], (size, 1)),
            seed=(self.seed * 1000 + round_) % 2**32,
            population_size=self.population,
        )

    def _setup(self, point: Point, trunk: Setup | None = None) -> Setup:
        trunk = trunk or self.trunk
        return replace(trunk, given={**trunk.given, **self.space.values(point)})

    def _race(self, setups: Sequence[Setup], first: int) -> list[Trial]:
        """Trials of these setups, in order; only those that are not in the study are raced."""
        best = self._best_before(first)
        limit = best.verdict.laps if best else None
        missing = []
        for index, setup in enumerate(setups):
            known = self.study.trials.get(first + index)
            if known is None:
                missing.append(index)
            elif not _same(known.given, setup.given):
                raise InputError(
                    f"study '{self.study.name}': trial {first + index} does not match this search; "
                    "it was made by another version; use another --name"
                )

        def done(job: int, verdict: Verdict) -> None:
            index = missing[job]
            self._keep(first + index, setups[index], verdict, self.starts[index].name if first == 0 else "")

        race_all(self.pool, [(self.problem, setups[i].given, limit) for i in missing], done)
        return [self.study.trials[first + index] for index in range(len(setups))]

    def _keep(self, number: int, setup: Setup, verdict: Verdict, start: str) -> None:
        trial = Trial(number, setup.given, verdict, self._cost(verdict), start, round(self.seconds, 3))
        self.study.add(trial, self.space)
        self.done(trial)

    def _cost(self, verdict: Verdict) -> float:
        return verdict.cost(self.reference or verdict.lap or self.problem.track.length)


def default_population(axes: int) -> int:
    """By Hansen's rule, rounded to an even number for two workers."""
    size = 4 + int(3 * np.log(axes))
    return size + size % 2


def _same(a: Values, b: Values) -> bool:
    return a.keys() == b.keys() and all(abs(float(a[key]) - float(b[key])) < 1e-12 for key in a)


def _why(trials: Sequence[Trial]) -> str:
    words = []
    for trial in trials:
        verdict = trial.verdict
        outcome = next((o for o in verdict.outcomes if o != "finished"), "no lap")
        words.append(f"{trial.start}: {outcome.replace('_', ' ')} in {verdict.failed} of {verdict.raced} races")
    return ", ".join(words)
