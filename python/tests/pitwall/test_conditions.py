"""Races under other conditions: another car, and --option NAME=VALUE for the race and the true car."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
QUICK = ("--setup", "base", "--laps", 1, "--json")


def test_an_option_changes_the_race_and_is_told(cli):
    plain = cli("race", "oval", *QUICK).json
    slippery = cli("race", "oval", *QUICK, "--option", "mu_scale=0.5", "--option", "race.delay_extra=0.02").json
    assert plain["options"] == {}
    assert slippery["options"] == {"mu_scale": 0.5, "delay_extra": 0.02}
    assert slippery["laps"] != plain["laps"]


@pytest.mark.parametrize(
    "condition",
    [
        "sensors.speed_scale_error=0.02",
        "vehicle.speed_constant_error=0.02",
        "vehicle.steering_trim=0.01",
        "vehicle.steering_gain=1.02",
        "sensors.laser_x_error=0.02",
        "sensors.laser_y_error=0.02",
        "sensors.laser_yaw_error=0.02",
        "sensors.odometry_fault=4",
        "lidar.noise_sigma=0",
    ],
)
def test_what_the_car_really_is_is_a_condition_too(cli, condition):
    name, _, value = condition.partition("=")
    plain = cli("race", "oval", *QUICK).json
    other = cli("race", "oval", *QUICK, "--option", condition).json
    assert other["options"] == {name: float(value)}
    assert (other["outcome"], other["laps"]) != (plain["outcome"], plain["laps"])


def test_the_driver_is_not_told_what_the_car_really_is(cli, tmp_path):
    (tmp_path / "shifted.yaml").write_text("geometry:\n  laser_x: 0.32\n")
    told = cli("race", "oval", *QUICK, "--car", tmp_path / "shifted.yaml").json
    untold = cli("race", "oval", *QUICK, "--option", "sensors.laser_x_error=0.05").json
    assert told["laps"] != untold["laps"]


def test_a_survey_drives_under_the_conditions_and_says_so(cli):
    arguments = ("survey", "oval", "--setup", "base", "--laps", 1, "--seeds", 1, "--option", "start_offset=0.3")
    found = cli(*arguments, "--car", "nuc2", "--json").json
    assert (found["options"], found["car"]) == ({"start_offset": 0.3}, "nuc2")
    raced = cli("race", "oval", *QUICK, "--option", "start_offset=0.3", "--car", "nuc2").json
    assert found["tracks"][0]["best"] == raced["best"]
    output = " ".join(cli(*arguments, "--car", "nuc2").out.split())
    assert "car nuc2" in output
    assert "start_offset 0.3" in output


def test_titles_of_plain_races_say_nothing_of_conditions(cli):
    assert "car default" not in cli("survey", "oval", "--setup", "base", "--laps", 1, "--seeds", 1).out


@pytest.mark.parametrize(
    ("assignment", "says"),
    [
        ("mu_scal=1", "did you mean race.mu_scale"),
        ("mu_scale", "--option mu_scale=0.85"),
        ("mu_scale=9", "0.05 to 3"),
        ("mu_scale=nan", "not a number"),
        ("laps=3", "use --laps"),
        ("record_path=0", "records its path"),
    ],
)
@pytest.mark.parametrize("command", ["race", "survey"])
def test_a_wrong_option_is_one_line_that_helps(cli, command, assignment, says):
    ran = cli(command, "oval", "--option", assignment)
    assert (ran.code, ran.out) == (2, "")
    assert re.fullmatch(r"error: .+\n", ran.err)
    assert says in ran.err


def test_the_results_page_shows_conditions_apart(cli, tmp_path, capsys):
    files = []
    for name, more in (("plain", ()), ("slippery", ("--option", "mu_scale=0.9"))):
        found = cli("survey", "oval", "--setup", "base", "--laps", 1, "--seeds", 1, "--json", *more)
        files.append(tmp_path / f"{name}.json")
        files[-1].write_text(json.dumps(found.json))
    spec = importlib.util.spec_from_file_location("results", ROOT / "scripts" / "results_page.py")
    assert spec is not None and spec.loader is not None
    results = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(results)
    results.main([*(str(file) for file in files), "--elsewhere", str(files[0]), str(files[0])])
    page = capsys.readouterr().out
    assert page.count("\n## `base`") == 1
    conditions = page.split("## Other conditions")[1]
    assert "`base`, mu_scale 0.9: 1 of 1 races finished (1 lap x 1 seed)" in conditions
    assert re.search(r"\| oval \| 1 of 1, \d\.\d\d m \|", conditions)
    assert "1 lap x 1 seed, 1 map: 1 of 1 races finished." in page
    assert "Its laps are 1.000 of those of `base`" in page


def test_bench_takes_any_track(cli, tmp_path):
    text = (ROOT / "tracks" / "oval.yaml").read_text().replace("name: oval", "name: mine")
    (tmp_path / "mine.yaml").write_text(text)
    found = cli("bench", tmp_path / "mine.yaml", "--json").json
    assert found["track"] == "mine"
    assert found["scan_us"]["p50"] > 0.0


def test_a_race_that_ends_stuck_says_why(cli):
    blind = ("race", "oval", *QUICK[:-1], "--option", "lidar.dropout_rate=1")
    ran = cli(*blind, "--json")
    assert ran.code == 1
    assert ran.json["outcome"] == "stuck"
    reason = "0 of 1081 beams return a range between range_min 0.06 m and range_max 30 m; at least 4 are needed"
    assert ran.json["ending"] == {"status": "bad_scan", "scan_fault": "no_returns", "scan_reason": reason}
    assert f"stuck after 3.00 s: last status bad_scan; last scan: {reason}" in cli(*blind).out
    failures = cli("survey", *blind[1:], "--seeds", 1, "--json").json["tracks"][0]["failures"]
    assert failures[0]["ending"] == ran.json["ending"]
    assert cli("race", "oval", *QUICK).json["ending"] is None


@pytest.mark.parametrize("command", [("race",), ("survey", "--seeds", 1), ("compare", "--drivers", "gap")])
@pytest.mark.parametrize(
    ("option", "says"),
    [
        (
            "lidar.beams_vary=1000 lidar.beams=900",
            "lidar.beams_vary is 1000, allowed at most lidar.beams - 2, which is 898",
        ),
        (
            "lidar.rate=100",
            "lidar.sweep_time is 0.01875, allowed at most one scan period, 1 / lidar.rate, which is 0.01 s",
        ),
    ],
)
def test_options_that_contradict_each_other_are_named_and_not_the_track(cli, command, option, says):
    given = [word for one in option.split() for word in ("--option", one)]
    ran = cli(command[0], "oval", *command[1:], *given, "--laps", 1)
    assert ran.code == 2
    assert ran.err == f"error: --option {', '.join(option.split())}: {says}\n"


def test_a_car_file_that_contradicts_itself_is_named(cli, tmp_path):
    (tmp_path / "slow.yaml").write_text("lidar:\n  rate: 40\n  sweep_time: 0.05\n")
    for option in ("--car", "--lidar"):
        ran = cli("race", "oval", option, "slow.yaml")
        assert (ran.code, ran.err.split(": ")[:2]) == (2, ["error", "slow.yaml"])
        assert "lidar.sweep_time is 0.05, allowed at most one scan period" in ran.err


def test_a_start_beyond_a_wall_is_refused(cli):
    ran = cli("race", "oval", "--option", "start_offset=10")
    why = "race: the car starts beyond a wall, 10 m left of the centerline"
    assert (ran.code, ran.err) == (2, f"error: oval with race options start_offset=10: {why}\n")


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ("--lidar", "'': no such LiDAR or file; available: ld19, lds01, rplidar_a1, "),
        ("--car", "'': no such car or file; available: default, nuc2, gym"),
        ("--setup", "'': no such setup or file; available: base, "),
    ],
)
def test_a_name_that_is_empty_is_answered_with_those_there_are(cli, option, says):
    ran = cli("race", "oval", option, "")
    assert (ran.code, ran.err.startswith(f"error: {says}")) == (2, True), ran.err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("explain", "oval", "--laser", "0.1,0,0"), "--laser: has no effect with a track"),
        (("explain", "oval", "--keep-body"), "--keep-body: has no effect with a track"),
        (("map", "oval", "-o", "m.yaml", "--scan-topic", "/scan"), "--scan-topic: has no effect with a track"),
    ],
)
def test_an_option_of_recordings_is_refused_with_a_track(cli, arguments, says):
    ran = cli(*arguments)
    assert (ran.code, ran.err) == (2, f"error: {says}\n")
