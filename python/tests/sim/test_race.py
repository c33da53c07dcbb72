"""Complete races from Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import firstlap
from firstlap.common.errors import InputError
from firstlap.evaluation.survey import Run, Survey


def test_a_race_is_laps_and_a_path(arena):
    result = firstlap.race(arena, "base", laps=2, seed=1)
    assert result.finished
    assert [lap.standing for lap in result.laps] == [True, False]
    assert sum(lap.time for lap in result.laps) == pytest.approx(result.time, abs=0.05)
    for lap in result.laps:
        assert lap.mean_speed == pytest.approx(lap.distance / lap.time)
        assert lap.min_clearance > 0.05
    assert {len(column) for column in result.path.values()} == {len(result.path["time"])}
    assert len(result.compute_times) > 100


def test_the_same_seed_gives_the_same_race_bit_for_bit(arena):
    first, second = (firstlap.race(arena, "base", laps=1, seed=7) for _ in range(2))
    assert first.laps == second.laps
    for name, column in first.path.items():
        assert np.array_equal(column, second.path[name]), name


def test_another_seed_gives_another_race(arena):
    first, second = (firstlap.race(arena, "base", laps=1, seed=seed) for seed in (1, 2))
    assert first.laps != second.laps


@pytest.mark.parametrize("car", ["default", "nuc2", "gym"])
def test_every_car_finishes_the_oval(car):
    assert firstlap.race(firstlap.load_track("oval"), "base", car, laps=1).finished


def test_race_beats_base_on_arena(arena):
    base, fast = (firstlap.race(arena, name, laps=3) for name in ("base", "race"))
    assert base.finished
    assert fast.finished
    assert fast.best < 0.8 * base.best


@pytest.mark.parametrize("track", ["arena", "hairpins", "slalom"])
@pytest.mark.parametrize("reverse", [False, True])
def test_brisk_is_faster_than_sure_and_keeps_off_the_walls(track: str, reverse: bool):
    sure, brisk = (
        firstlap.race(firstlap.load_track(track), name, laps=2, reverse=reverse) for name in ("sure", "brisk")
    )
    assert sure.finished and brisk.finished
    assert brisk.best < 0.9 * sure.best
    assert min(lap.min_clearance for lap in brisk.laps) > 0.15


def test_a_contact_ends_the_race_on_a_wall(arena):
    setup = firstlap.load_setup("race").with_values({"v_min": 8.0, "a_y_max": 15.0})
    result = firstlap.race(arena, setup)
    assert result.outcome == "contact"
    point = np.array([result.contact.x, result.contact.y])
    nearest = min(_distance(point, wall) for wall in arena.walls)
    assert nearest < 1e-6


def _distance(point: np.ndarray, wall: np.ndarray) -> float:
    start, step = wall[:-1], np.diff(wall, axis=0)
    share = np.clip(((point - start) * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.hypot(*(start + share[:, None] * step - point).T).min())


def test_options_of_the_table_reach_the_race(arena):
    slippery = firstlap.race(arena, "base", laps=1, options={"mu_scale": 0.3})
    assert slippery.laps != firstlap.race(arena, "base", laps=1).laps


@pytest.mark.parametrize("options", [{"mu_scal": 1.0}, {"mu_scale": 99.0}])
def test_options_that_cannot_be_are_refused(arena, options):
    with pytest.raises(InputError):
        firstlap.race(arena, "base", laps=1, options=options)


def test_look_may_stop_a_race(arena):
    def on_progress(_running: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        firstlap.race(arena, "base", on_progress=on_progress)


def test_a_race_without_a_lap_can_be_drawn(arena, tmp_path: Path):
    setup = firstlap.load_setup("race").with_values({"v_min": 8.0, "a_y_max": 15.0})
    result = firstlap.race(arena, setup)
    result.plot(tmp_path / "a.svg")
    assert (tmp_path / "a.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_a_survey_gives_what_single_races_give(arena):
    survey = Survey(firstlap.load_setup("base"), firstlap.load_car("default"), laps=1)
    survey.drive([Run("arena", arena, False, seed) for seed in (1, 2, 3)])
    alone = [firstlap.race(arena, "base", laps=1, seed=seed).laps for seed in (1, 2, 3)]
    together = sorted(survey.summaries["arena"].results, key=lambda result: result.seed)
    assert [result.laps for result in together] == alone
