"""From many trials to two setups: the fastest that holds on fresh seeds, and the fastest seen."""

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
"""Called with what is done and how many races are over."""


@dataclass(frozen=True)
class Chosen:
    """A trial and what it did on fresh seeds."""

    trial: Trial
    check: Verdict

    @property
    def lap(self) -> float:
        """Mean flying lap on the fresh seeds [s]."""
        return self.check.lap or float("inf")

    @property
    def success(self) -> float:
        """Share of the races on fresh seeds that were finished."""
        return 1.0 - self.check.failed / max(self.check.raced, 1)


@dataclass(frozen=True)
class Selection:
    """holds: none where nothing did. seen: the fastest on fresh seeds of what was raced there, which the fastest lap of
    the search always is, of those that finished at least every other race. tried: what was raced there to find `holds`.
    compared: the start that laps are compared with, on the same seeds."""

    holds: Chosen | None
    seen: Chosen | None
    tried: list[Chosen]
    compared: Verdict


def usual_laps(judge: dict[str, float]) -> float:
    """What a choice simulates, about: the finalists, the start and the fastest seen wholly, some that fail at once."""
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
    """Races the best trials again, on seeds that the search never saw. Raises PoolGoneError.

    The cheapest that hold are tried one after the other; after one that fails, the next must have kept more clearance.
    Among the first `finalists` that hold, the fastest on the fresh seeds is chosen.
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
    """Under all conditions, or until a stage of them shows that it does not hold."""
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
    """One setup under many conditions, shared among the workers. Raises PoolGoneError."""
    parts = [tuple(conditions[i : i + CHUNK]) for i in range(0, len(conditions), CHUNK)]
    jobs = [(replace(problem, conditions=part), given, None) for part in parts]
    verdicts = race_all(pool, jobs, lambda _index, verdict: progress("fresh seeds", verdict.raced))
    return merged(verdicts, problem.margin)


def merged(verdicts: Sequence[Verdict], margin: float) -> Verdict:
    """One verdict of all races of several."""
    return Verdict(
        laps=[lap for v in verdicts for lap in v.laps],
        progress=[share for v in verdicts for share in v.progress],
        clearances=[clearance for v in verdicts for clearance in v.clearances],
        margin=margin,
        outcomes=[outcome for v in verdicts for outcome in v.outcomes],
        driven=sum(v.driven for v in verdicts),
    )


def pareto_front(trials: Sequence[Trial]) -> list[Trial]:
    """Of the trials that finished every race: those that no other beats in both lap and clearance, fastest first."""
    whole = [t for t in trials if t.verdict.lap and t.verdict.failed == 0 and not t.verdict.ended]
    result: list[Trial] = []
    for trial in sorted(whole, key=lambda t: (t.verdict.lap, -t.verdict.clearance)):
        if not result or trial.verdict.clearance > result[-1].verdict.clearance:
            result.append(trial)
    return result
