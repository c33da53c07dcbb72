"""Names and types in results of races, steps and logs, which users' scripts rely on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.config.car_file import load_car
from firstlap.config.driver_kind import CoreHandle, Preparation
from firstlap.config.setup_file import choose_setup
from firstlap.drivers import driver_kind
from firstlap.sim.race import start_race

REACTIVE = {"ranges", "first_beam", "beam_step", "result"}
WALL = {"points", "outward", "age"}
PATH = {"s", "x", "y", "yaw", "curvature", "velocity"}
TRACES: dict[str, set[str]] = {
    "local": {
        *("points", "point_range", "point_beam", "sections", "samples", "sample_section", "sample_vote", "candidates"),
        *("split", "left", "right", "line", "smoothed", "simplified", "path", "nearest", "lookahead", "steering"),
        *("width", "clearance", "speed_scale", "command_scale", "result"),
    },
    "gap": REACTIVE
    | {"free", "step", "threshold", "run", "window", "aim", "aim_free", "nearest", "wanted", "arc", "arc_free"},
    "disparity": REACTIVE
    | {"extended", "disparities", "block", "aim", "aim_free", "straight_free", "wanted", "held_left", "held_right"},
    "pid": REACTIVE | {"left", "right", "error", "derivative", "preview", "p_term", "i_term", "d_term", "free"},
}
PARTS: dict[str, dict[str, set[str]]] = {
    "local": {
        "sections": {"first", "last", "nearest", "length", "angle", "status"},
        "left": WALL,
        "right": WALL,
        "line": {"points", "width", "support", "right", "left", "nearest", "ahead", "end"},
        "path": PATH,
        "lookahead": PATH,
        "steering": {
            *("heading_error", "cross_track_error", "yaw_rate_error", "steering_change"),
            *("heading", "cross_track", "yaw_rate", "steering", "lookahead", "k_ang", "steering_angle"),
        },
    },
    "pid": {side: {"side", "ahead", "angle", "distance", "preview"} for side in ("left", "right")},
}
RESULT = {"outcome", "time", "distance", "laps", "contact", "skipped_scans", "obstacle", "compute_times", "path"}
RACE_PATH = {
    *("time", "x", "y", "yaw", "speed", "yaw_rate", "steering_angle", "s", "lateral_offset"),
    *("command_speed", "command_steering_angle", "status"),
}
LOG = {
    *("speed", "steering_angle", "status", "microseconds", "width", "width_seen", "left_seen", "right_seen"),
    *("clearance", "ahead", "nearest", "lookahead", "left", "left_size", "right", "right_size"),
    *("line", "line_size", "path", "path_size", "ranges", "sizes", "headers", "measured", "dt"),
}


def driven(driver: str, scans: int = 60, logged: bool = False) -> tuple[_core.Race, Any, Any]:
    """A running race, its driver and its log."""
    car, setup = load_car("default"), choose_setup(driver, None)
    handle = driver_kind(driver).make(setup.params(car.core), car, Preparation())
    log = _core.LoggedDriver(handle.core) if logged else None
    race = start_race(firstlap.load_track("arena"), CoreHandle(log) if log else handle, car, laps=1)
    race.advance(scans)
    return race, handle, log


@pytest.mark.parametrize("driver", TRACES)
def test_a_trace_has_the_names_that_scripts_know(driver: str) -> None:
    _, handle, _ = driven(driver)
    assert set(handle.trace) == TRACES[driver]
    for part, names in PARTS.get(driver, {}).items():
        assert set(handle.trace[part]) == names, part
    speed, steering_angle, status = handle.trace["result"]
    assert isinstance(speed, float)
    assert isinstance(steering_angle, float)
    assert status in _core.STATUSES


def test_the_arrays_of_a_trace_are_as_long_as_what_they_tell_of() -> None:
    _, handle, _ = driven("local")
    trace = handle.trace
    assert trace["points"].shape == (len(trace["point_range"]), 2) == (len(trace["point_beam"]), 2)
    assert trace["samples"].shape == (len(trace["sample_vote"]), 2)
    assert trace["sections"]["last"][-1] == len(trace["points"]) - 1
    assert {trace["sections"]["first"].dtype, trace["point_beam"].dtype} == {np.dtype(np.int64)}
    assert {trace["sections"]["status"].dtype, trace["line"]["support"].dtype} == {np.dtype(np.uint8)}
    assert trace["sample_vote"].dtype == np.int8
    assert trace["left"]["points"].shape == trace["left"]["outward"].shape == (len(trace["left"]["age"]), 2)
    split, score = trace["candidates"][0]
    assert isinstance(split, int)
    assert isinstance(score, float)


def test_a_race_has_the_names_that_scripts_know() -> None:
    race, _, _ = driven("gap")
    found = race.result()
    assert set(found) == RESULT
    assert set(found["path"]) == RACE_PATH
    assert (found["outcome"], found["contact"], found["obstacle"], found["laps"]) == ("running", None, None, [])
    assert found["compute_times"].dtype == np.float32
    assert found["path"]["status"].dtype == np.uint8


@pytest.mark.parametrize("driver", ["local", "gap"])
def test_a_log_has_the_names_that_scripts_know(driver: str) -> None:
    _, _, log = driven(driver, scans=5, logged=True)
    columns = log.take()
    assert set(columns) == LOG
    traced = 5 if driver == "local" else 0
    assert len(columns["speed"]) == 5
    assert len(columns["width"]) == len(columns["left_size"]) == traced
    assert columns["lookahead"].shape == (traced, 2)
    for name in ("left", "right", "line", "path"):
        assert columns[name].shape == (columns[f"{name}_size"].sum(), len(_core.result_tables()[name]))


def test_a_lap_is_a_value_with_the_names_of_its_table() -> None:
    lap = _core.Lap(time=9.5, distance=30.0)
    assert list(lap.to_dict()) == [column["name"] for column in _core.result_tables()["Lap"]]
    assert _core.Lap(**lap.to_dict()) == lap
    assert lap != _core.Lap(time=9.6, distance=30.0)


def test_the_place_of_an_obstacle_stands_in_its_table() -> None:
    names = [column["name"] for column in _core.result_tables()["ObstacleSeen"]]
    assert names == ["time", "x", "y", "yaw", "speed", "yaw_rate", "clearance"]
    assert _core.ObstacleSeen(yaw=0.5).to_dict()["yaw"] == 0.5
