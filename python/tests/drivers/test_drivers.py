"""All drivers: names, setups, races, and error messages for wrong combinations."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.driver_kind import CoreHandle, TableParams
from firstlap.config.setup_file import Setup, choose_setup, list_setups, load_setup, parse_setup
from firstlap.drivers import DRIVERS, DriverKind, Preparation, driver_kind
from firstlap.explain.snapshot import explain_race
from firstlap.explain.step_plots import STEP_PLOTS, plot_step
from firstlap.sim.race import latency_options, start_race

OPPONENTS = ("gap", "disparity", "pid")
MAP_LESS = ("local", *OPPONENTS)


class Cruise:
    """A driver in Python: steers to the side with more clearance."""

    def __init__(self, speed: float = 2.0) -> None:
        self.speed = speed
        self.calls: list[tuple[Any, ...]] = []
        self.resets = 0

    def step(self, scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> tuple[float, float, str]:
        """Computes a command."""
        self.calls.append((scan, state, dt))
        ranges = scan.ranges
        angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        near = np.minimum(ranges, 4.0)
        left, right = (near[np.abs(angles - side) < 0.4].mean() for side in (1.0, -1.0))
        return self.speed, float(np.clip((left - right) / (left + right), -0.4, 0.4)), "ok"

    def reset(self) -> None:
        """Does nothing: the driver has no state."""
        self.resets += 1


def ride(driver: object, track: firstlap.Track, laps: int = 1, **options: float) -> _core.Race:
    """Runs a race of a driver in Python."""

    handle = CoreHandle(_core.CallbackDriver(driver))
    return start_race(track, handle, firstlap.load_car("default"), laps=laps, options=options)


@pytest.mark.parametrize("name", MAP_LESS)
def test_every_driver_races_and_says_who_it_was(cli, name):
    ran = cli("race", "oval", "--driver", name, "--laps", 1, "--json")
    assert ran.code == 0, ran
    assert ran.json["driver"] == name
    assert load_setup(ran.json["setup"]).driver == name


@pytest.mark.parametrize("name", MAP_LESS)
def test_the_default_setup_of_a_driver_is_its_own(name):
    assert choose_setup(name, None).driver == name
    assert DRIVERS[name].default_setup in list_setups(name)
    assert not DRIVERS[name].needs_map


@pytest.mark.parametrize("name", MAP_LESS)
def test_parameter_names_of_a_driver_are_unique_so_that_set_needs_no_section(name):
    names = [field.name for field in DRIVERS[name].fields.fields]
    assert len(names) == len(set(names))
    for field in DRIVERS[name].fields.fields:
        assert field.min <= field.default <= field.max
        assert field.doc


@pytest.mark.parametrize("name", MAP_LESS)
def test_a_value_set_is_the_value_that_the_driver_gets(name):
    setup = choose_setup(name, None).with_assignments(["v_max=2.5", "wheelbase=0.4"])
    section = DRIVERS[name].fields.find("v_max", "test").section
    assert setup.params().get(section, "v_max") == 2.5
    assert setup.params(firstlap.load_car("gym").core).get("car", "wheelbase") == 0.4
    assert firstlap.race(firstlap.load_track("oval"), setup, laps=1).path["command_speed"].max() <= 2.5


@pytest.mark.parametrize("name", OPPONENTS)
def test_the_same_seed_gives_the_same_race(arena, name):
    first, second = (firstlap.race(arena, driver=name, laps=1, seed=3) for _ in range(2))
    assert first.laps == second.laps
    assert np.array_equal(first.path["x"], second.path["x"])


@pytest.mark.parametrize("name", OPPONENTS)
def test_check_knows_the_opponents_setups(cli, name):
    ran = cli("check", name)
    assert ran.code == 0
    assert "grip in corners" in ran.out


@pytest.mark.parametrize("name", OPPONENTS)
def test_explain_draws_a_step_of_every_opponent(cli, name):
    ran = cli("explain", "arena", "--driver", name, "--at", 3)
    assert ran.code == 0, ran
    assert Path("explain.png").stat().st_size > 20_000


@pytest.mark.parametrize("name", OPPONENTS)
def test_explain_draws_a_step_without_data(cli, name):
    ranges = np.full((3, 1081), np.inf)
    ranges[0] = 2.0
    np.savez("lost.npz", ranges=ranges, angle_min=-2.3, angle_increment=0.004)
    assert cli("explain", "lost.npz", "--driver", name, "--scan", 1).code == 0


def test_a_setup_alone_chooses_its_driver(cli):
    assert cli("race", "oval", "--setup", "gap", "--laps", 1, "--json").json["driver"] == "gap"


def test_survey_names_its_driver(cli):
    ran = cli("survey", "oval", "--driver", "disparity", "--laps", 1, "--seeds", 1, "--json")
    assert (ran.json["driver"], ran.json["setup"]) == ("disparity", "disparity")


BAD = {
    "unknown driver": (("race", "oval", "--driver", "gapp"), "'gapp' is not a driver; did you mean gap"),
    "driver unlike any": (("race", "oval", "--driver", "xyzzy"), "available: local, gap, disparity, pid"),
    "setup of another driver": (("race", "oval", "--driver", "gap", "--setup", "base"), "for driver local, not"),
    "opponent's setup": (("race", "oval", "--driver", "local", "--setup", "gap"), "available for local: base"),
    "parameter of another driver": (("race", "oval", "--driver", "gap", "--set", "k_ang=1"), "unknown parameter"),
    "survey, unknown driver": (("survey", "oval", "--driver", "no"), "is not a driver"),
    "explain, wrong setup": (("explain", "oval", "--driver", "pid", "--setup", "gap"), "not for pid"),
    "bench of an opponent": (("bench", "oval", "--setup", "gap"), "not for local"),
    "latency": (("race", "oval", "--latency", "soon"), "expected measured, none, or fixed:MS"),
    "negative latency": (("race", "oval", "--latency", "fixed:-1"), "0 to 300 ms"),
    "endless latency": (("race", "oval", "--latency", "fixed:nan"), "0 to 300 ms"),
}


@pytest.mark.parametrize(("arguments", "reason"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line_and_exit_2(cli, arguments, reason):
    answer = cli(*arguments)
    assert answer.code == 2
    assert re.fullmatch(r"error: .+\n", answer.err)
    assert reason in answer.err


def test_a_setup_file_names_its_driver():
    setup = parse_setup("driver: gap\nspeed:\n  v_max: 3\n", "mine.yaml")
    assert (setup.driver, setup.get("v_max")) == ("gap", 3.0)
    assert parse_setup("stanley:\n  k_ang: 0.4\n", "mine.yaml").driver == "local"
    with pytest.raises(InputError, match=r"mine\.yaml: driver: 'gapp' is not a driver"):
        parse_setup("driver: gapp\n", "mine.yaml")
    with pytest.raises(InputError, match=r"mine\.yaml: driver"):
        parse_setup("driver: [gap]\n", "mine.yaml")
    with pytest.raises(InputError, match="unknown section 'stanley'"):
        parse_setup("driver: gap\nstanley:\n  k_ang: 1\n", "mine.yaml")
    with pytest.raises(InputError, match=r"speed\.v_min"):
        parse_setup("driver: pid\nspeed:\n  v_min: 9\n", "mine.yaml")


def test_a_driver_in_python_races_in_the_same_race(arena):
    driver = Cruise()
    race = ride(driver, arena)
    while race.advance(40):
        pass
    found = race.result()
    assert found["outcome"] == "finished"
    assert len(driver.calls) == len(found["compute_times"])
    scan, state, dt = driver.calls[-1]
    assert scan.ranges.dtype == np.float32
    assert scan.ranges.shape == (1081,)
    assert state == race.measured()
    assert dt == 0.025
    assert scan.angle_increment == pytest.approx(1.5 * np.pi / 1080)


def test_an_exception_of_a_driver_in_python_ends_the_race_with_it(arena):
    class Lost(Cruise):
        def step(self, *arguments: Any) -> tuple[float, float, str]:
            if len(self.calls) == 20:
                raise RuntimeError("lost my way")
            return super().step(*arguments)

    race = ride(Lost(), arena)
    with pytest.raises(RuntimeError, match="lost my way"):
        race.advance(100)
    assert race.result()["path"]["command_speed"][-1] == 0.0, "the car is told to stop"
    assert not race.advance()


@pytest.mark.parametrize("answer", [None, (1.0, 0.0), (float("nan"), 0.0, "ok"), (1.0, 0.0, "fine")])
def test_an_answer_that_is_no_command_ends_the_race(arena, answer):
    class Odd(Cruise):
        def step(self, *_arguments: Any) -> Any:
            return answer

    with pytest.raises((TypeError, ValueError, RuntimeError)):
        ride(Odd(), arena).advance(5)


def test_a_slow_driver_in_python_feels_it_where_latency_is_measured(arena):
    import time

    class Slow(Cruise):
        def step(self, *arguments: Any) -> tuple[float, float, str]:
            begin = time.thread_time()
            while time.thread_time() - begin < 0.06:
                pass
            return super().step(*arguments)

    late = ride(Slow(), arena, measure_latency=True)
    late.advance(20)
    assert late.result()["skipped_scans"] >= 8
    patient = ride(Slow(), arena)
    patient.advance(5)
    assert patient.result()["skipped_scans"] == 0


def test_a_late_driver_skips_scans_and_says_so(cli):
    ran = cli("race", "oval", "--driver", "gap", "--laps", 1, "--latency", "fixed:60")
    assert "scans arrived while the driver was busy" in ran.out
    found = cli("race", "oval", "--driver", "gap", "--laps", 1, "--latency", "fixed:60", "--json").json
    assert found["latency"] == "fixed:60"
    assert found["skipped_scans"] > 100


def test_latency_is_none_by_default_so_that_races_repeat(arena):
    assert latency_options("none") == {}
    assert latency_options("measured") == {"measure_latency": True}
    assert latency_options("fixed:7.5") == {"compute_latency": 0.0075}
    assert firstlap.race(arena, driver="pid", laps=1).latency == "none"


def test_parameters_of_a_python_driver_come_from_its_table():
    params = TableParams(driver_kind("gap").fields)
    assert params.values() == _core.FollowTheGapParams().values()
    params.set("speed", "v_max", 3.0)
    assert params.get("speed", "v_max") == 3.0
    with pytest.raises(ValueError, match="v_max"):
        params.set("speed", "v_max", 300.0)
    with pytest.raises(KeyError):
        params.set("speed", "warp", 9.0)


def test_what_a_driver_prepares_is_given_to_its_make(arena):
    kind = DRIVERS["gap"]
    setup = choose_setup("gap", None)
    prepared = kind.prepare(arena, setup, firstlap.load_car("default"), 1, None)
    assert prepared == Preparation()
    assert kind.make(setup.params(), None, prepared).trace["result"][2] == "no_path"


def test_a_driver_is_loaded_when_it_is_asked_for(arena, tmp_path):
    asked: list[str] = []

    def load() -> DriverKind:
        asked.append("planned")
        return replace(DRIVERS["gap"], name="planned", default_setup="gap")

    DRIVERS.register_lazily("planned", load)
    try:
        assert "planned" in DRIVERS and "planned" in list(DRIVERS)
        assert asked == []
        assert driver_kind("planned").name == driver_kind("planned").name == "planned"
        assert asked == ["planned"]
        setup, car = Setup("x", driver="planned"), firstlap.load_car("default")
        snapshot = explain_race(arena, setup, car, 1.0, seed=1, reverse=False)
        with pytest.raises(InputError, match="driver planned: no plot of a step; expected one of local,"):
            plot_step(snapshot, tmp_path / "x.png")
    finally:
        DRIVERS.forget("planned")
    assert "planned" not in DRIVERS


def test_every_driver_has_a_picture_and_the_other_way_round():
    assert list(DRIVERS) == list(STEP_PLOTS)
