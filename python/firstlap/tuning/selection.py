"""Selects two setups from the trials: the fastest reliable one on the check seeds, and the fastest seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from firstlap.config.parameters import Values
from firstlap.tuning.candidate import Problem, Verdict
from firstlap.tuning.pool import Pool, race_all
from firstlap.tuning.study import Trial
from firstlap.tuning.variation import Conditions, checks

CHUNK = 5
STAGE = 15
MOST_TRIES = 12
USUAL_FAILURES = 4
Progress = Callable[[str, int], object]
"""Called with the current activity and the number of finished races."""


@dataclass(frozen=True)
class Chosen:
    """A trial and its result on the check seeds."""

    trial: Trial
    check: Verdict

    @property
    def lap(self) -> float:
        """Mean flying lap on the check seeds [s]."""
        return self.check.lap or float("inf")

    @property
    def success(self) -> float:
        """Share of finished races on the check seeds."""
        return 1.0 - self.check.failed / max(self.check.raced, 1)


@dataclass(frozen=True)
class Selection:
    """holds: the fastest reliable trial, or None. seen: the fastest trial on the check seeds that finished at least
    half of its races there; the fastest lap of the search is always among them. tried: the trials raced to find
    `holds`. compared: the starting setup that laps are compared with, on the same seeds."""

    holds: Chosen | None
    seen: Chosen | None
    tried: list[Chosen]
    compared: Verdict


def usual_laps(judge: dict[str, float]) -> float:
    """The approximate number of laps of a selection: finalists, start and fastest seen, and some that fail early."""
    races = (judge["finalists"] + 2) * judge["check_seeds"] + USUAL_FAILURES * STAGE
    return races * judge["check_laps"]


def choose(
    problem: Problem,
    trials: Sequence[Trial],
    compared: Values,
    pool: Pool,
    judge: dict[str, float],
    seed: int,
    progress: Progress,
) -> Selection:
    """Races the best trials again, on seeds not used in the search. Raises PoolGoneError.

    The reliable trials of lowest cost are tried one after the other; after a failure, the next must have more
    clearance. Among the first `finalists` that are reliable, the fastest on the check seeds is selected.
    """
    fresh = replace(problem, laps=int(judge["check_laps"]), patient=True)
    conditions = checks(int(judge["check_seeds"]), seed)
    waiting = sorted((t for t in trials if t.verdict.holds), key=lambda t: (t.cost, t.number))
    tried: list[Chosen] = []
    passed: list[Chosen] = []
    while waiting and len(passed) < judge["finalists"] and len(tried) < MOST_TRIES:
        trial = waiting.pop(0)
        chosen = Chosen(trial, _race_while_it_holds(fresh, trial.given, conditions, pool, progress))
        tried.append(chosen)
        if chosen.check.holds:
            passed.append(chosen)
        else:
            waiting = [other for other in waiting if other.verdict.clearance > trial.verdict.clearance]
    holds = min(passed, key=lambda chosen: chosen.lap, default=None)
    seen = _fastest_seen(fresh, trials, conditions, tried, pool, progress)
    return Selection(holds, seen, tried, race_conditions(fresh, compared, conditions, pool, progress))


def _race_while_it_holds(
    problem: Problem, given: Values, conditions: Sequence[Conditions], pool: Pool, progress: Progress
) -> Verdict:
    """Races under all conditions, or until a stage shows that the candidate is not reliable."""
    found: list[Verdict] = []
    for first in range(0, len(conditions), STAGE):
        found.append(race_conditions(problem, given, conditions[first : first + STAGE], pool, progress))
        if not found[-1].holds:
            break
    return merged(found, problem.margin)


def _fastest_seen(
    fresh: Problem,
    trials: Sequence[Trial],
    conditions: Sequence[Conditions],
    tried: Sequence[Chosen],
    pool: Pool,
    progress: Progress,
) -> Chosen | None:
    seen = [t for t in trials if t.verdict.lap and 2 * t.verdict.failed <= t.verdict.raced]
    fastest = min(seen, key=lambda t: (t.verdict.lap, t.number), default=None)
    if fastest is None:
        return None
    whole = [chosen for chosen in tried if chosen.check.raced == len(conditions)]
    if all(chosen.trial.number != fastest.number for chosen in whole):
        whole.append(Chosen(fastest, race_conditions(fresh, fastest.given, conditions, pool, progress)))
    return min(whole, key=lambda chosen: (chosen.lap, chosen.trial.number))


def race_conditions(
    problem: Problem, given: Values, conditions: Sequence[Conditions], pool: Pool, progress: Progress
) -> Verdict:
    """Races one setup under many conditions, distributed over the workers. Raises PoolGoneError."""
    parts = [tuple(conditions[i : i + CHUNK]) for i in range(0, len(conditions), CHUNK)]
    jobs = [(replace(problem, conditions=part), given, None) for part in parts]
    verdicts = race_all(pool, jobs, lambda _index, verdict: progress("fresh seeds", verdict.raced))
    return merged(verdicts, problem.margin)


def merged(verdicts: Sequence[Verdict], margin: float) -> Verdict:
    """Merges several results into one."""
    return Verdict(
        laps=[lap for v in verdicts for lap in v.laps],
        progress=[share for v in verdicts for share in v.progress],
        clearances=[clearance for v in verdicts for clearance in v.clearances],
        margin=margin,
        outcomes=[outcome for v in verdicts for outcome in v.outcomes],
        driven=sum(v.driven for v in verdicts),
    )


def pareto_front(trials: Sequence[Trial]) -> list[Trial]:
    """The Pareto front of lap time and clearance, of the trials that finished every race, fastest first."""
    whole = [t for t in trials if t.verdict.lap and t.verdict.failed == 0 and not t.verdict.ended]
    result: list[Trial] = []
    for trial in sorted(whole, key=lambda t: (t.verdict.lap, -t.verdict.clearance)):
        if not result or trial.verdict.clearance > result[-1].verdict.clearance:
            result.append(trial)
    return result
