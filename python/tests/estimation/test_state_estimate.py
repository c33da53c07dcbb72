"""The state estimate in races, compared with the truth."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from firstlap import load_car, load_setup, load_track, race
from firstlap.cli import run
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.evaluation.estimation.cases import CASES, Case
from firstlap.evaluation.estimation.drive import Drive, drive, errors
from firstlap.sim.race import start_race

BY_NAME = {case.name: case for case in CASES}
ENABLED = {"state_estimate.enabled": True}


def driven(case: Case, track: str = "arena", setup: str = "sure") -> Drive:
    return drive(load_track(track), load_setup(setup), load_car("default"), case, laps=1, seed=2)


@pytest.fixture(scope="module")
def found() -> dict[str, dict[str, object]]:
    """The errors of each case."""
    return {name: errors([driven(case)]) for name, case in BY_NAME.items()}


def ratio(row: dict[str, object], what: str) -> float:
    """Error of the estimate divided by that of the measured value."""
    part = row[what]
    assert isinstance(part, dict)
    return float(part["estimate"] / part["raw"])


def test_races_with_the_estimate_finish_in_every_case(found):
    assert all(row["finished"] == row["races"] == 1 for row in found.values())


def test_with_clean_sensors_it_is_no_worse_than_the_measured_values(found):
    assert ratio(found["clean"], "speed") < 1.0
    assert ratio(found["clean"], "yaw_rate") < 1.1
    assert ratio(found["clean"], "steering_angle") < 1.5


@pytest.mark.parametrize("case", ["slip", "lock", "all"])
def test_the_error_is_at_least_halved_where_wheels_slip_or_lock(found, case):
    assert ratio(found[case], "speed") < 0.5


@pytest.mark.parametrize("case", ["lock", "all"])
def test_the_error_is_at_least_halved_while_the_wheels_are_locked(found, case):
    assert found[case]["locked"]["scans"] > 10
    assert ratio(found[case], "locked") < 0.5


def test_the_gyro_bias_is_found_while_driving(found):
    assert found["bias"]["yaw_rate_bias"]["error"] < 0.25 * found["bias"]["yaw_rate_bias"]["true"]
    assert ratio(found["bias"], "yaw_rate") < 0.7


def test_side_slip_is_estimated(found):
    assert ratio(found["clean"], "lateral_speed") < 0.7


def test_a_race_with_the_estimate_is_repeatable_and_differs_from_one_without():
    track = load_track("oval")
    first, again = (race(track, "sure", laps=1, options=ENABLED) for _ in range(2))
    assert first.finished
    assert first.best == again.best
    assert first.best != race(track, "sure", laps=1).best


def test_without_it_the_driver_is_given_the_measured_state():
    setup, car = load_setup("sure"), load_car("default")
    handle = driver_kind(setup.driver).make(setup.params(car.core), car, Preparation())
    running = start_race(load_track("oval"), handle, car, laps=1)
    for _ in range(50):
        running.advance()
        wheel_speed, yaw_rate, steering_angle, *_ = running.reading()
        assert tuple(running.measured()) == (wheel_speed, yaw_rate, steering_angle)


def test_every_reading_has_its_true_value():
    one = driven(BY_NAME["slip"], "oval")
    assert {len(column) for part in (one.readings, one.truth, one.estimates) for column in part.values()} == {
        len(one.times)
    }
    still = np.abs(one.readings["acceleration_x"]) < 0.2
    assert np.abs(one.readings["wheel_speed"] - one.truth["speed"])[still].mean() < 0.1


def test_the_command_prints_the_errors_and_plots_a_race(capsys, tmp_path):
    picture = tmp_path / "slip.png"
    arguments = ["estimation", "oval", "--laps", "1", "--case", "slip"]
    assert run([*arguments, "--json", "--plot", str(picture)]) == 0
    (row,) = json.loads(capsys.readouterr().out)["cases"]
    assert row["case"] == "slip" and row["speed"]["estimate"] < 0.5 * row["speed"]["raw"]
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run(arguments) == 0
    assert "slip" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--case", "wind"], "--case wind: no such case; available: clean, bias, slip, lock, all"),
        (["--plot", "a.png"], "--plot: needs --case"),
        (["--setup", "global"], "driver global: needs a map"),
    ],
)
def test_wrong_options_are_named(capsys, arguments, message):
    assert run(["estimation", "oval", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_an_interrupted_comparison_prints_what_is_finished(monkeypatch, capsys):
    races = []

    def told(*arguments: Any, **options: Any) -> Drive:
        if races:
            raise KeyboardInterrupt
        races.append(drive(*arguments, **options))
        return races[0]

    monkeypatch.setattr("firstlap.evaluation.estimation.drive.drive", told)
    assert run(["estimation", "oval", "--laps", "1", "--json"]) == 130
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert found["interrupted"] is True
    assert [row["case"] for row in found["cases"]] == ["clean"]
    assert err == "error: interrupted after 1 of 5 cases\n"
