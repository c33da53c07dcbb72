"""The progress from the start to the tuned setup, as a few settings for the plots."""

from __future__ import annotations

from dataclasses import dataclass

from firstlap.config.parameters import Values
from firstlap.tuning.run import Tuned
from firstlap.tuning.study import Trial

MOST_STEPS = 4


@dataclass(frozen=True)
class Setting:
    """One setting. holds: whether it was reliable in the search, or, if it was selected, on the check seeds."""

    label: str
    given: Values
    lap: float | None
    holds: bool


def settings_of(tuned: Tuned) -> list[Setting]:
    """The start, the best so far at a few times of the search, and the two selected setups."""
    trials = tuned.study.ordered
    compared = next(trial for trial in trials if trial.given == tuned.search.compared.given)
    last = tuned.choice.holds.trial.number if tuned.choice.holds else len(trials)
    steps = [t for t in improvements(trials) if t.number < last and t.number != compared.number]
    if len(steps) > MOST_STEPS:
        steps = [steps[round(i * (len(steps) - 1) / (MOST_STEPS - 1))] for i in range(MOST_STEPS)]
    found = [_setting(compared, tuned.search.compared.name)]
    found += [_setting(trial, trial.start or f"trial {trial.number}") for trial in steps]
    if tuned.choice.holds:
        found.append(Setting("holds", tuned.choice.holds.trial.given, tuned.choice.holds.check.lap, True))
    if tuned.choice.seen and tuned.choice.seen.trial != (tuned.choice.holds and tuned.choice.holds.trial):
        seen = tuned.choice.seen
        found.append(Setting("seen", seen.trial.given, seen.check.lap or seen.trial.verdict.lap, seen.check.holds))
    return found


def improvements(trials: list[Trial]) -> list[Trial]:
    """The reliable trials that were faster than all before them."""
    found: list[Trial] = []
    for trial in trials:
        if trial.verdict.holds and (not found or trial.cost < found[-1].cost):
            found.append(trial)
    return found


def _setting(trial: Trial, label: str) -> Setting:
    return Setting(label, trial.given, trial.verdict.lap, trial.verdict.holds)
