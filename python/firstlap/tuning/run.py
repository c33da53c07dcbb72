"""A complete tuning: search, selection on check seeds, setup files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from firstlap.common.version import __version__
from firstlap.tracks.track import Track
from firstlap.tuning.candidate import Problem
from firstlap.tuning.pool import Pool
from firstlap.tuning.search import Budget, Search
from firstlap.tuning.selection import Chosen, Selection, choose, usual_laps
from firstlap.tuning.session import Session
from firstlap.tuning.setup_writer import write_setup
from firstlap.tuning.study import Study, Trial
from firstlap.tuning.validate import Validation, validate


class TuningProgress:
    """Progress callbacks of a tuning; all methods are optional."""

    def trial(self, search: Search, trial: Trial) -> None:
        """Called when a trial has finished."""

    def races(self, what: str, count: int) -> None:
        """Called when `count` races of a later step have finished."""


@dataclass(frozen=True)
class Tuned:
    """The result of a tuning. workers: number of parallel races."""

    session: Session
    search: Search
    choice: Selection
    workers: int

    @property
    def study(self) -> Study:
        """All trials."""
        return self.search.study

    @property
    def problem(self) -> Problem:
        """The races of the candidates."""
        return self.search.problem

    @property
    def gain(self) -> float | None:
        """Lap time saved by the reliable setup, as a share of the starting setup's lap."""
        holds = self.choice.holds
        return self.less(holds) if holds else None

    @property
    def reference(self) -> float:
        """Lap time of the starting setup on the check seeds [s]."""
        return self.choice.compared.lap or self.search.reference

    def less(self, chosen: Chosen) -> float:
        """Lap time saved by a setup, as a share of the starting setup's lap on the same seeds."""
        return 1.0 - chosen.lap / self.reference


def tune(session: Session, study: Study, pool: Pool, budget: Budget, watch: TuningProgress) -> Tuned:
    """Searches, then races the best again on check seeds; a budget in seconds covers both.

    Raises InputError if no starting setup finishes the track, PoolGoneError if the cluster is lost.
    """
    search = Search(
        session.problem(),
        session.starts,
        session.space,
        study,
        pool,
        session.seed,
        session.population,
        session.judge["slowest"],
    )
    search.done = lambda trial: watch.trial(search, trial)
    search.laps_after = usual_laps(session.judge)
    search.run(budget)
    given = search.compared.given
    choice = choose(search.problem, study.ordered, given, pool, session.judge, session.seed, watch.races)
    return Tuned(session, search, choice, pool.workers)


def validate_tuned(tuned: Tuned, others: Mapping[str, Track], pool: Pool, watch: TuningProgress) -> Validation | None:
    """Races the selected setup on unseen seeds and tracks; None without a reliable setup. Raises PoolGoneError."""
    holds = tuned.choice.holds
    if holds is None:
        return None
    session, compared = tuned.session, tuned.search.compared
    return validate(
        tuned.problem,
        holds.trial.given,
        (compared.name, compared.given),
        others,
        pool,
        session.judge,
        session.seed,
        lambda _what, count: watch.races("validation", count),
    )


def write_setups(tuned: Tuned, folder: Path) -> dict[str, Path]:
    """Writes the setups; returns {"holds": file, "seen": file} for those that exist. Raises InputError."""
    titles = {"holds": "the fastest reliable setup", "seen": "the fastest setup seen, which may fail"}
    written = {}
    for role, chosen in (("holds", tuned.choice.holds), ("seen", tuned.choice.seen)):
        if chosen is None:
            continue
        path = folder / f"{tuned.study.name}-{role}.yaml"
        header = _header(tuned, chosen, titles[role])
        write_setup(path, tuned.session.driver, chosen.trial.given, header, tuned.session.tuned_for)
        written[role] = path
    return written


def _header(tuned: Tuned, chosen: Chosen, title: str) -> list[str]:
    session, search, check = tuned.session, tuned.search, chosen.check
    verdict = chosen.trial.verdict
    spread = ", ".join(f"{name} ±{value:g}" for name, value in session.spread.items())
    saved = tuned.less(chosen)
    broken = sum(clearance < check.margin for clearance in check.clearances)
    found = f"start {chosen.trial.start}" if chosen.trial.start else f"trial {chosen.trial.number}"
    return [
        f"{title[0].upper()}{title[1:]} on {session.spec}, {'reverse' if session.reverse else 'forward'}, "
        f"car {session.car.name}: written by `firstlap tune`, version {__version__}.",
        "",
        f"study {tuned.study.name}, {found} of {len(tuned.study.trials)}, seed {session.seed}",
        f"search: {verdict.raced} races of {search.problem.laps} laps, {verdict.failed} failed, "
        f"lap {verdict.lap:.2f} s, clearance {verdict.clearance:.2f} m",
        f"check seeds: {check.raced} races of {int(session.judge['check_laps'])} laps, "
        f"{check.raced - check.failed} finished, lap {chosen.lap:.2f} s, clearance {check.clearance:.2f} m, "
        f"margin of {check.margin:g} m violated in {broken}",
        f"every race differs: {spread}",
        f"setup {search.compared.name} laps in {tuned.reference:.2f} s there: {100 * saved:.1f} % less",
    ]
