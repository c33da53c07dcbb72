"""The tuner: cost of candidates, search space, and stored results."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstlap
from firstlap.common.errors import InputError
from firstlap.config.setup_file import load_setup
from firstlap.tuning.candidate import Verdict, judge
from firstlap.tuning.pool import LocalPool
from firstlap.tuning.search import Budget, Search, parse_budget
from firstlap.tuning.selection import choose, pareto_front
from firstlap.tuning.session import make_session
from firstlap.tuning.space import make_space
from firstlap.tuning.study import Trial, only_one, open_study
from firstlap.tuning.variation import (
    EVALUATION_FIELDS,
    SPREAD_NAMES,
    changed_car,
    checks,
    corners,
    drawn,
    evaluation_values,
)

FEW = "a_y_max,v_max,k_ang"

pytest.importorskip("optuna", reason="the extra `tune` is not installed")
pytest.importorskip("cmaes", reason="the extra `tune` is not installed")


@pytest.fixture(scope="module")
def oval() -> firstlap.Track:
    return firstlap.load_track("oval")


def session_of(track: firstlap.Track, **options):
    defaults = {
        "driver": None,
        "start": None,
        "car": firstlap.load_car("default"),
        "judge": evaluation_values(),
        "seeds": 2,
        "only": FEW,
    }
    return make_session(track.name, track, **{**defaults, "population": 4, **options})


def found(track: firstlap.Track, path: Path, trials: int, workers: int = 1, name: str = "a") -> list[Trial]:
    """The trials of a search with one starting setup."""
    session = session_of(track)
    study = open_study(path, name, session.about())
    pool = LocalPool("local", workers)
    try:
        search = Search(session.problem(), session.starts[:1], session.space, study, pool, 1, session.population)
        search.run(Budget(trials=trials))
    finally:
        pool.close()
    return study.ordered


def plain(trials: list[Trial]) -> list[Trial]:
    return [replace(trial, seconds=0.0) for trial in trials]


def test_one_worker_two_workers_and_a_resumed_study_find_the_same(oval, tmp_path: Path):
    file, trials = tmp_path / "a.db", 8
    alone = plain(found(oval, file, trials))
    assert [trial.number for trial in alone] == list(range(trials))
    assert [trial.start for trial in alone[:2]] == ["base", ""]
    assert plain(found(oval, file, trials, workers=2, name="b")) == alone
    found(oval, file, 6, name="c")
    assert plain(found(oval, file, trials, name="c")) == alone


def test_the_search_begins_where_the_neighbors_of_a_start_do_best(oval, tmp_path: Path):
    session = session_of(oval)
    study = open_study(tmp_path / "a.db", "a", session.about())
    search = Search(session.problem(), session.starts, session.space, study, LocalPool("local", 1), 1)
    lone, good = ([session.starts[i]] * 3 for i in (1, 2))
    costs = [99.0, 8.0, 99.0, 12.0, 11.0, 50.0]
    trials = [Trial(3 + i, {}, Verdict([], [], [], 0.1), cost) for i, cost in enumerate(costs)]
    assert search._best_neighborhood({1: lone, 2: good}, trials) is session.starts[2]


def test_a_finished_study_races_nothing_again(oval, tmp_path: Path):
    first = found(oval, tmp_path / "a.db", 2)
    assert found(oval, tmp_path / "a.db", 2) == first


def test_the_worst_that_holds_is_cheaper_than_any_broken_margin_and_that_than_any_contact():
    slow = Verdict([15.0], [1.0], [0.08], 0.08)
    near = Verdict([5.0], [1.0], [0.0799], 0.08)
    touch = Verdict([5.0, None], [1.0, 0.99], [0.3, 0.0], 0.08)
    early = Verdict([None], [0.01], [0.0], 0.08)
    costs = [verdict.cost(10.0) for verdict in (slow, near, touch, early)]
    assert costs == sorted(costs)
    assert slow.holds
    assert not near.holds
    assert not touch.holds


def test_a_hopeless_candidate_ends_early(oval):
    problem = session_of(oval, seeds=8).problem()
    values = load_setup("base").with_values({"a_y_max": 15.0, "v_min": 8.0, "v_max": 9.0}).given
    crashed = judge(problem, values)
    assert crashed.ended == "failed twice"
    assert crashed.raced == 2
    slow = judge(problem, load_setup("base").given, best=[5.0] * 8)
    assert slow.ended == "too slow"
    assert slow.raced == 2
    assert not slow.holds


def test_values_that_contradict_each_other_are_not_raced(oval):
    verdict = judge(
        session_of(oval).problem(), {("velocity_profile", "v_min"): 9.0, ("velocity_profile", "v_max"): 3.0}
    )
    assert verdict.raced == 0
    assert verdict.cost(10.0) == 50.0


def test_corners_meet_every_pair_of_ends_equally_often_and_the_worst_first():
    shares = np.array([[c.share[name] for name in SPREAD_NAMES] for c in corners(8, 1)])
    assert set(np.abs(shares).ravel()) == {1.0}
    assert np.array_equal(shares.T @ shares, 8 * np.eye(len(SPREAD_NAMES)))
    first = dict(zip(SPREAD_NAMES, shares[0], strict=True))
    assert first["friction"] == -1.0
    assert first["delay"] == 1.0


def test_seeds_of_search_choice_and_validation_never_meet():
    seeds = [c.seed for c in (*corners(50, 1), *drawn(50, 1, "choice"), *drawn(50, 1, "validation"))]
    assert len(set(seeds)) == 150
    assert min(seeds) > 10_000


def test_the_spread_changes_the_car_by_what_the_table_says():
    car = firstlap.load_car("default")
    spread = {name: evaluation_values()[name] for name in SPREAD_NAMES}
    worst, plain_car = changed_car(car, spread, corners(1, 1)[0]).core, car.core
    ratio = {
        name: worst.get("vehicle", name) / plain_car.get("vehicle", name)
        for name in ("friction", "mass", "servo_time_constant")
    }
    assert ratio == pytest.approx({"friction": 0.9, "mass": 1.1, "servo_time_constant": 1.2})
    assert worst.get("vehicle", "steering_delay") == pytest.approx(plain_car.get("vehicle", "steering_delay") + 0.02)


@pytest.mark.parametrize("driver", ["local", "gap", "disparity", "pid"])
def test_ranges_lie_within_the_field_tables_and_hold_every_start(driver: str):
    session = session_of(firstlap.load_track("oval"), driver=driver, only=None)
    for axis in session.space.axes:
        assert axis.field.min <= axis.low < axis.high <= axis.field.max
        for start in session.starts:
            assert axis.low <= float(start.get(axis.field.key)) <= axis.high, axis.field.key
    point = session.space.to_unit(session.starts[0])
    assert ((point >= 0.0) & (point <= 1.0)).all()
    for value, unit, axis in zip(session.space.values(point).values(), point, session.space.axes, strict=True):
        assert math.isclose(axis.to_unit(float(value)), unit, abs_tol=0.01)


def test_only_and_fix_choose_what_is_searched():
    starts = [load_setup("base"), load_setup("race")]
    assert [axis.field.name for axis in make_space(starts, "k_ang, l_max", None).axes] == ["k_ang", "l_max"]
    assert [axis.field.name for axis in make_space(starts, "k_ang,l_max", "l_max").axes] == ["k_ang"]
    for only, fix in (("", None), ("k_angle", None), ("k_ang", "k_ang")):
        with pytest.raises(InputError):
            make_space(starts, only, fix)


def test_only_leaves_everything_else_as_in_the_start(oval):
    session = session_of(oval, only="k_ang,l_max")
    base = load_setup("base")
    for start in session.starts:
        changed = {row.name for row in base.fields.fields if start.get(row.key) != base.get(row.key)}
        assert changed <= {"k_ang", "l_max"}


def test_the_front_holds_what_nothing_else_beats():
    def trial(number: int, lap: float, clearance: float) -> Trial:
        return Trial(number, {}, Verdict([lap], [1.0], [clearance], 0.1), lap)

    trials = [trial(0, 12.0, 0.5), trial(1, 11.0, 0.2), trial(2, 11.5, 0.2), trial(3, 10.0, 0.0), trial(4, 13.0, 0.4)]
    assert [t.number for t in pareto_front(trials)] == [3, 1, 0]


@pytest.mark.parametrize(
    ("text", "budget"), [("3m", Budget(seconds=180)), ("90s", Budget(seconds=90)), ("7", Budget(7))]
)
def test_a_budget_is_a_time_or_a_number_of_trials(text: str, budget: Budget):
    assert parse_budget(text) == budget


@pytest.mark.parametrize("text", ["0", "0m", "-3m", "", "m", "2.5", "nan", "inf", "1e12", "soon"])
def test_a_budget_of_nothing_is_refused(text: str):
    with pytest.raises(InputError, match="--budget"):
        parse_budget(text)


def test_the_table_of_the_judge_names_each_row_once():
    names = [row.name for row in EVALUATION_FIELDS.fields]
    assert len(set(names)) == len(names)
    with pytest.raises(InputError, match="margin"):
        evaluation_values(["margn=1"])


def test_a_study_is_tuned_by_one_process_at_a_time(tmp_path: Path):
    file = tmp_path / "a.db"
    with (
        only_one(file, "a"),
        only_one(file, "b"),
        pytest.raises(InputError, match="another process"),
        only_one(file, "a"),
    ):
        pass
    with only_one(file, "a"):
        pass
    assert not list(tmp_path.iterdir())


def test_a_budget_of_time_leaves_time_for_the_choice(oval, tmp_path: Path):
    session = session_of(oval)
    study = open_study(tmp_path / "a.db", "a", session.about())
    search = Search(session.problem(), session.starts, session.space, study, LocalPool("local", 1), 1, population=4)
    verdict = Verdict([9.0], [1.0], [0.5], 0.1, driven=10.0)
    study.trials = {n: Trial(n, {}, verdict, 9.0, seconds=float(n)) for n in range(10)}
    search._seconds_before, search.laps_after = 10.0, 100.0
    assert search._out_of_time(Budget(seconds=21.0), 10)
    assert not search._out_of_time(Budget(seconds=25.0), 10)
    assert not search._out_of_time(Budget(seconds=21.0), 9)
    search.laps_after = 1e9
    assert not search._out_of_time(Budget(seconds=25.0), 10)


def test_where_nothing_better_comes_the_search_begins_anew(oval, tmp_path: Path):
    session = session_of(oval)
    study = open_study(tmp_path / "a.db", "a", session.about())
    search = Search(session.problem(), session.starts, session.space, study, LocalPool("local", 1), 1, population=4)
    worse = Verdict([9.0], [1.0], [0.5], 0.1)
    study.trials = {n: Trial(n, {}, worse, 8.0 if n == 6 else 9.0) for n in range(30)}
    assert not search._stale(18, begun=3)
    assert search._stale(19, begun=3)
    assert not search._stale(19, begun=15)


def test_starts_are_ours_or_those_that_are_named_or_the_first_alone(oval):
    def names(**options) -> list[str]:
        return [start.name for start in session_of(oval, **options).starts]

    assert {"base", "race", "sure", "local_arena"} <= set(names(only=None))
    assert names(only=None, others="race,sure,base") == ["base", "race", "sure"]
    assert names(only=None, others="none") == ["base"]
    for others in ("", ",", "nowhere", "gap"):
        with pytest.raises(InputError):
            session_of(oval, others=others)


def test_the_fastest_seen_is_never_slower_on_fresh_seeds_than_what_holds(oval):
    session = session_of(oval)
    base, race = (load_setup(name).given for name in ("base", "race"))
    held = Verdict([9.0] * 2, [1.0] * 2, [0.5] * 2, 0.08)
    trials = [Trial(0, base, replace(held, laps=[5.0] * 2), 5.0), Trial(1, race, held, 9.0)]
    judging = evaluation_values(["check_seeds=2", "check_laps=2"])
    pool = LocalPool("local", 2)
    try:
        choice = choose(session.problem(), trials, base, pool, judging, 1, lambda _what, _races: None)
    finally:
        pool.close()
    assert choice.holds is not None
    assert choice.holds.trial.number == 1
    assert choice.seen == choice.holds


def test_half_of_the_races_of_the_choice_are_at_the_worst_ends_and_the_rest_anywhere():
    found = checks(40, 1)
    assert [c.seed for c in found] == [c.seed for c in drawn(40, 1, "choice")]
    worst = [c.share["friction"] == -1.0 and c.share["delay"] == c.share["servo"] == 1.0 for c in found]
    assert worst == [True] * 20 + [False] * 20
    assert len({c.share["mass"] for c in found}) == 40
    assert len(checks(1, 1)) == 1
