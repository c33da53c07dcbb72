"""The odometry check on recordings of simulated and real cars."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from command_result import CommandResult

from firstlap import Car, _core, load_car, load_setup, load_track, race
from firstlap.cli import view
from firstlap.evaluation.replay.replay import replay
from firstlap.explain.snapshot import explain_recording
from firstlap.mapping import make
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.odometry_of_recording import odometry_of, remarks_of, steps_of
from firstlap.recordings import Recording, Topics, load_recording

DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the real recordings (../shared/data) are not here")
REAL = (
    *("scans/germany2022", "scans/hangar12", "scans/rollcage", "scans/straight_1_speed_1"),
    *("scans/sinside_corner_1_speed_1", "more/scans/hangar_1905", "more/scans/uos_jj_1359", "more/scans/glc_ot_ez"),
    *("more/scans/ist_20250920", "more/scans/ulsan_1017_3", "more/scans/unita_test2"),
)
Fault = Callable[[Recording], Recording]


def scaled(speed: float, yaw_rate: float) -> Fault:
    """The recording with scaled speed and yaw rate."""
    return lambda one: replace(one, states=one.states * np.array([speed, yaw_rate, 1.0]))


def in_the_frame_of_the_map(one: Recording) -> Recording:
    """The twist rotated by the yaw of its poses."""
    odometry = odometry_of(one)
    assert odometry is not None
    assert odometry.poses is not None
    poses = odometry.poses
    states = one.states.copy()
    states[:, 0] *= np.cos(poses[:, 2])
    return replace(one, states=states, lateral_speed=one.speed * np.sin(poses[:, 2]))


def without_poses(one: Recording) -> Recording:
    """As from wheel odometry that only publishes a twist."""
    return replace(one, poses=None, odometry=None)


FAULTS = [
    pytest.param(scaled(-1.0, 1.0), "wrong sign", id="negated"),
    pytest.param(scaled(3.6, 1.0), "km/h instead of m/s", id="km/h"),
    pytest.param(scaled(0.0, 1.0), "stands at 0", id="0"),
    pytest.param(scaled(1.0, math.degrees(1.0)), "degrees per second", id="deg/s"),
    pytest.param(scaled(1.0, -1.0), "wrong sign", id="turning negated"),
    pytest.param(in_the_frame_of_the_map, "frame of the car", id="frame"),
]


@pytest.fixture(scope="module")
def lap(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The log of a lap of arena, with true poses as odometry."""
    path = tmp_path_factory.mktemp("odometry") / "lap.mcap"
    race(load_track("arena"), "sure", laps=1, seed=2, record=path)
    recording = load_recording(path)
    return replace(recording, odometry=recording.poses)


@pytest.mark.parametrize("poses", [True, False], ids=["poses", "no poses"])
@pytest.mark.parametrize(("fault", "words"), FAULTS)
def test_each_fault_is_said_of_a_race(lap: Recording, fault: Fault, words: str, poses: bool) -> None:
    broken = fault(lap)
    remarks = remarks_of(broken if poses else without_poses(broken), load_car("default"))
    assert any(words in one for one in remarks), remarks


def test_replay_says_it_and_says_nothing_of_an_honest_race(lap: Recording) -> None:
    car, setup = load_car("default"), load_setup("sure")
    assert replay(lap, setup, car).remarks == ()
    remarks = replay(scaled(3.6, 1.0)(lap), setup, car).remarks
    assert any("where the scans say" in one for one in remarks)
    assert any("where its poses say" in one for one in remarks)
    assert all("km/h instead of m/s" in one for one in remarks)


@pytest.fixture(scope="module")
def in_km_h(lap: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of the same lap with the speed in km/h."""
    path = tmp_path_factory.mktemp("km_h") / "lap.npz"
    angle_min, angle_increment = lap.headers[0, :2].tolist()
    np.savez(
        path, ranges=np.array(list(lap.ranges)), angle_min=angle_min, angle_increment=angle_increment,
        stamps=lap.stamps, speed=3.6 * lap.speed, yaw_rate=lap.yaw_rate,
    )  # fmt: skip
    return path


def test_explain_says_it_too(in_km_h: Path) -> None:
    moment = explain_recording(load_recording(in_km_h), load_setup("sure"), load_car("default"), 3)
    assert any("km/h instead of m/s" in one for one in moment.remarks)


def test_view_says_it_too(cli: Callable[..., CommandResult], in_km_h: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("viser")
    monkeypatch.setattr(view, "_serve", lambda *_: 0)
    ran = cli("view", in_km_h, "--no-open")
    assert ran.code == 0, ran.err
    assert "km/h instead of m/s" in ran.err


def test_map_says_it_too(cli: Callable[..., CommandResult], in_km_h: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = OccupancyMap(np.zeros((3, 3), dtype=np.uint8), 0.05, (0.0, 0.0, 0.0))
    monkeypatch.setattr(make, "map_observations", lambda *_, **__: SimpleNamespace(map=drawn, to_dict=dict))
    ran = cli("map", in_km_h, "-o", "map.yaml", "--json")
    assert ran.code == 0, ran.err
    assert any("km/h instead of m/s" in one for one in ran.json["remarks"])


@pytest.mark.parametrize(
    ("track", "setup", "sensors", "options"),
    [
        ("hairpins", "brisk", {"speed_scale_error": 0.15}, {}),
        ("arena", "sure", {"speed_scale_error": -0.15}, {}),
        ("arena", "sure", {"latency": 0.2}, {}),
        ("arena", "sure", {"speed_noise": 0.3, "yaw_rate_noise": 0.3, "yaw_rate_bias": 0.2}, {}),
        ("hairpins", "race", {}, {"mu_scale": 0.7}),
    ],
)
def test_errors_noise_latency_and_slides_of_a_race_are_no_contradiction(
    tmp_path: Path, track: str, setup: str, sensors: dict[str, float], options: dict[str, float]
) -> None:
    core = _core.Car.preset("default")
    for name, value in sensors.items():
        core.set("sensors", name, value)
    car = Car("with errors", core)
    race(load_track(track).reversed(), setup, car, laps=1, seed=2, options=options, record=tmp_path / "lap.mcap")
    assert remarks_of(load_recording(tmp_path / "lap.mcap"), car) == ()


def real(name: str) -> Recording:
    """A recording of a real car."""
    return load_recording(next((DATA / name).glob("*.npz")))


@needs_data
@pytest.mark.parametrize("name", REAL)
def test_real_cars_do_not_contradict_themselves(name: str) -> None:
    assert remarks_of(real(name), load_car("default")) == ()


@needs_data
@pytest.mark.parametrize("odom", ["/vesc/odom", "/car_state/odom", "/car_state/odom_diff", "/state_estimation/odom"])
def test_every_odometry_of_a_real_bag_agrees_with_its_scans(odom: str) -> None:
    drive = "/vesc/low_level/ackermann_cmd_mux/output"
    (bag,) = (DATA / "more/scans/uos_lab_233131").glob("*.bag")
    recording = load_recording(bag, Topics(odom=odom, drive=drive, pose="none"))
    car = load_car("default")
    steps = steps_of(recording, car, 0.0, recording.duration)
    told = np.isfinite(steps.motion[:, 0])
    speed = np.interp(steps.ends[told], recording.stamps, recording.speed)
    np.testing.assert_allclose(steps.motion[told, 0] / (steps.ends - steps.begins)[told], speed, atol=0.4)
    assert remarks_of(recording, car) == ()


@needs_data
@pytest.mark.parametrize("poses", [True, False], ids=["poses", "no poses"])
@pytest.mark.parametrize(("fault", "words"), FAULTS)
def test_each_fault_is_said_of_a_real_car(fault: Fault, words: str, poses: bool) -> None:
    broken = fault(real("more/scans/hangar_1905"))
    remarks = remarks_of(broken if poses else without_poses(broken), load_car("default"))
    assert any(words in one for one in remarks), remarks


def test_where_nothing_was_measured_nothing_is_said(lap: Recording) -> None:
    unmeasured = replace(scaled(-1.0, 1.0)(lap), sources={**lap.sources, "speed": "none"})
    assert remarks_of(unmeasured, load_car("default")) == ()
