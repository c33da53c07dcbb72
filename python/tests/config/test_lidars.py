"""Planar LiDARs: all presets complete laps, and the first beam's direction does not matter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, list_lidars, load_car, with_lidar
from firstlap.perception.scan import judge

FULL_TURN = {"beams": 720, "fov": 2.0 * math.pi * 719 / 720, "rate": 10.0, "range_max": 12.0, "sweep_time": 0.0999}
WAYS = {
    "begins ahead": {"center_angle": math.pi},
    "begins ahead, turns right": {"center_angle": math.pi, "clockwise": True},
    "begins at the side": {"center_angle": 1.0, "clockwise": True},
    "cable to the rear": {"yaw": math.pi},
    "upside down": {"upside_down": True, "center_angle": math.pi},
    "varying number of beams": {"beams_vary": 20},
}


def full_turn(**changes: Any) -> Car:
    """The default car with a 360° LiDAR whose scans start behind the car by default."""
    core = _core.Car.preset("default")
    for name, value in {**FULL_TURN, **changes}.items():
        core.set("lidar", name, value)
    core.validate()
    return Car("full turn", core)


@pytest.mark.parametrize("lidar", list_lidars())
def test_every_lidar_of_ours_laps(lidar: str) -> None:
    car = with_lidar(load_car("default"), lidar)
    assert firstlap.race(firstlap.load_track("oval"), "sure", car, laps=1).finished


SETUPS = ["sure", "gap", "disparity", "pid"]


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("way", WAYS)
def test_every_driver_laps_wherever_the_scan_begins(setup: str, way: str) -> None:
    assert firstlap.race(firstlap.load_track("oval"), setup, full_turn(**WAYS[way]), laps=1).finished


@pytest.mark.parametrize("setup", SETUPS)
def test_the_seam_itself_changes_no_lap(setup: str) -> None:
    """A scan without sweep time and noise, so that only rounding errors of angles remain."""
    quiet = {"sweep_time": 0.0, "noise_sigma": 0.0, "dropout_rate": 0.0}
    track = firstlap.load_track("oval")
    usual = firstlap.race(track, setup, full_turn(**quiet), laps=1)
    for way in ("begins ahead", "begins ahead, turns right", "cable to the rear"):
        other = firstlap.race(track, setup, full_turn(**quiet, **WAYS[way]), laps=1)
        assert other.laps[0].time == pytest.approx(usual.laps[0].time, rel=0.01), way


@pytest.mark.parametrize("how", [0, 1, 2, 3])
@pytest.mark.parametrize("range_max", [4.0, 6.0, 8.0])
def test_no_return_is_no_wall_however_it_is_reported(how: int, range_max: float) -> None:
    core = _core.Car.preset("default")
    core.set("lidar", "range_max", range_max)
    core.set("lidar", "no_return", how)
    assert firstlap.race(firstlap.load_track("arena"), "sure", Car("short", core), laps=1).finished


def test_a_lidar_file_says_what_is_wrong(tmp_path, cli) -> None:
    with pytest.raises(InputError, match="did you mean rplidar_a2"):
        with_lidar(load_car("default"), "rplidar_a22")
    path = tmp_path / "mine.yaml"
    path.write_text("lidar:\n  beams: 10\n  beams_vary: 9\n")
    with pytest.raises(InputError, match=r"mine.yaml: lidar.beams_vary is 9, allowed at most lidar.beams - 2"):
        with_lidar(load_car("default"), path)
    path.write_text("vehicle:\n  mass: 3\n")
    with pytest.raises(InputError, match=r"vehicle.mass is not a LiDAR parameter"):
        with_lidar(load_car("default"), path)
    ran = cli("race", "oval", "--lidar", "nosuch")
    assert ran.code == 2
    assert "no such LiDAR" in ran.err


def test_a_lidar_replaces_all_of_the_cars_own() -> None:
    car = with_lidar(load_car("gym"), "utm30lx")
    assert car.core.get("lidar", "dropout_rate") == load_car("default").core.get("lidar", "dropout_rate")
    assert car.core.get("vehicle", "model") == 1


def a_scan(**changes: Any) -> _core.LaserScan:
    """A valid scan."""
    ranges = np.full(1081, 2.0, dtype=np.float32)
    header = {"angle_min": -2.356, "angle_increment": 4.712 / 1080, "time_increment": 1.7e-5, "range_min": 0.05}
    return _core.LaserScan(**{"ranges": ranges, **header, "range_max": 30.0, **changes})


def test_a_good_scan_has_no_reason_and_no_remark() -> None:
    assert judge(a_scan(), 0.025, 2.356) == ("none", "", ())


@pytest.mark.parametrize(
    ("changes", "fault", "says"),
    [
        ({"angle_min": -135.0, "angle_increment": 0.25}, "too_wide", "degrees"),
        ({"ranges": np.full(1081, 600.0, dtype=np.float32), "range_max": 12000.0}, "nothing_in_reach", "millimeters"),
        ({"time_increment": -1e-5}, "time_increment", "0 or more"),
        ({"range_min": -math.inf}, "not_finite", "range_min -inf"),
        ({"angle_increment": 0.01}, "too_wide", "more than a full turn"),
        ({"angle_min": 0.8}, "blind_ahead", "mounting"),
        ({"ranges": np.full(1081, np.nan, dtype=np.float32)}, "no_returns", "0 of 1081"),
    ],
)
def test_a_bad_scan_has_a_reason(changes, fault: str, says: str) -> None:
    judged = judge(a_scan(**changes))
    assert judged.fault == fault
    assert says in judged.reason


def test_a_sweep_longer_than_the_period_is_remarked() -> None:
    judged = judge(a_scan(time_increment=1e-4), 0.025)
    assert judged.fault == "none"
    assert "longer than the scan period" in judged.remarks[0]


def test_every_spelling_of_no_return_is_none() -> None:
    ranges = np.array([np.nan, np.inf, -np.inf, 0.0, -1.0, 0.04, 29.97, 30.0, 65.5, 2.0], dtype=np.float32)
    assert a_scan(ranges=ranges).returns().tolist() == [False] * 9 + [True]
