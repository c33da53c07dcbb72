"""Replays: the planner on recorded scans."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path

import bags
import numpy as np
import pytest

from firstlap import load_car, load_setup, load_track, race
from firstlap.common.errors import InputError
from firstlap.estimation.columns import READINGS, in_columns
from firstlap.evaluation.replay.continuity import Continuity
from firstlap.evaluation.replay.estimated import readings_of
from firstlap.evaluation.replay.replay import Replay
from firstlap.evaluation.replay.replay import replay as run_replay
from firstlap.explain.snapshot import explain_recording
from firstlap.explain.step_plots import plot_step
from firstlap.perception.scan import Mount
from firstlap.recordings import Recording, Topics, load_recording
from firstlap.recordings.body import find_body
from firstlap.recordings.laser import parse_laser

SCANS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "scans"
needs_scans = pytest.mark.skipif(not SCANS.is_dir(), reason="the real recordings (../shared/data) are not here")
PNG = b"\x89PNG\r\n"
KEYS = {
    "version",
    "recording",
    "topics",
    "sources",
    "remarks",
    "scans",
    "seconds",
    "from",
    "car",
    "driver",
    "setup",
    "set",
    "statuses",
    "sides",
    "width",
    "available",
    "jump",
    "changes_of_side",
    "step_us",
    "recorded",
    "scans_per_second",
}


def drive(recording: Recording, setup: str = "base", **options: object) -> Replay:
    return run_replay(recording, load_setup(setup), load_car("default"), **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive of 3 s along a corridor."""
    return bags.write_rosbag2(tmp_path_factory.mktemp("bag") / "corridor", bags.entries(120))


@pytest.fixture(scope="module")
def corridor(bag: Path) -> Recording:
    return load_recording(bag)


def test_a_corridor_is_seen_as_it_is(corridor):
    found = drive(corridor).to_dict()
    assert found["statuses"] == {"ok": 120}
    assert found["sides"] == {"both": 1.0, "one": 0.0, "none": 0.0}
    assert found["width"]["median"] == pytest.approx(2.0, abs=0.03)
    assert found["available"] == {"1": 1.0, "2": 1.0, "3": 1.0}
    assert found["jump"]["p95"] < 0.05
    assert found["changes_of_side"]["count"] == 0
    assert found["recorded"]["steering_angle"]["median"] == pytest.approx(0.05, abs=0.03)


def test_batches_are_the_same_as_step_by_step(corridor):
    from firstlap.drivers.racer import Racer, step_core

    racer = Racer("base", load_car("default"))
    single = [
        step_core(racer.core, corridor.scan(i), corridor.state(i), dt) for i, dt in enumerate(corridor.dts.tolist())
    ]
    driven = drive(corridor).driven
    assert driven.speed.tolist() == [command.speed for command in single]
    assert driven.steering_angle.tolist() == [command.steering_angle for command in single]


def test_a_second_setup_sees_the_same_scans(corridor):
    same = drive(corridor, against=load_setup("base")).to_dict()
    assert same["difference"]["speed"] == {"median": 0.0, "p95": 0.0}
    assert same["difference"]["steering_angle"] == {"median": 0.0, "p95": 0.0}
    slow = load_setup("base").with_values({"v_min": 0.5, "v_max": 0.5})
    other = drive(corridor, against=slow).to_dict()
    assert other["against"]["setup"] == "base"
    assert other["difference"]["speed"]["median"] > 0.5


def test_from_and_to_are_seconds_after_the_first_scan(cli, bag):
    found = cli("replay", bag, "--from", 1, "--to", 2, "--json").json
    assert set(found) == KEYS
    assert (found["scans"], found["from"], found["seconds"]) == (41, 1.0, 1.0)
    ran = cli("replay", bag, "--from", 50)
    assert ran.code == 2
    assert "it lasts 2.98 s" in ran.err


def test_replay_prints_a_table_and_draws_it(cli, bag):
    ran = cli("replay", bag, "--setup", "base", "--against", "race", "--plot", "a.png")
    assert ran.code == 0, ran.err
    for words in (
        "120 scans",
        "setup base",
        "setup race",
        "compared with the commands of /drive",
        "base compared with race",
    ):
        assert words in " ".join(ran.out.split())
    assert "speed from odometry (/odom)" in ran.out
    assert Path("a.png").read_bytes().startswith(PNG)
    assert cli("replay", bag, "--odom-topic", "none", "--pose-topic", "none", "--plot", "b.png").code == 0
    assert Path("b.png").read_bytes().startswith(PNG)


def test_what_people_read_is_in_words_and_degrees(cli, bag):
    ran = cli("replay", bag, "--setup", "base", "--against", "race", "--speed", 2)
    assert "the speed of 2 m/s is not used" in ran.err
    found = re.search(r"base compared with race: steering angle difference ([0-9.]+), ([0-9.]+)°", ran.out)
    assert found
    radians = cli("replay", bag, "--setup", "base", "--against", "race", "--json").json["difference"]["steering_angle"]
    assert float(found[1]) == pytest.approx(math.degrees(radians["median"]), abs=0.051)
    alone = cli("replay", bag, "--driver", "pid").out
    assert ": visible walls, width" in alone
    assert "│ -" not in alone


def test_explain_draws_a_scan_of_a_recording(cli, bag):
    ran = cli("explain", bag, "--scan", 100, "--setup", "base")
    assert ran.code == 0, ran.err
    assert Path("explain.png").read_bytes().startswith(PNG)
    assert cli("explain", bag, "--scan", -1, "--plot", "last.png").code == 0
    assert "no scan 120; expected 0 to 119" in cli("explain", bag, "--scan", 120).err


def test_explain_shows_the_step_of_the_replay(corridor):
    moment = explain_recording(corridor, load_setup("base"), load_car("default"), 77)
    driven = drive(corridor).driven
    assert moment.trace["result"][:2] == (driven.speed[77], driven.steering_angle[77])


def with_body(recording: Recording, beams: slice, length: float) -> Recording:
    """A recording in which some beams hit the car itself."""
    ranges = [one.copy() for one in recording.ranges]
    for one in ranges:
        one[beams] = length
    return replace(recording, ranges=ranges)


def test_returns_of_the_car_itself_are_found_and_masked(corridor):
    seen = with_body(corridor, slice(28, 40), 0.5)
    found = drive(seen)
    assert found.body is not None
    assert found.body.beams == 12
    assert "12 beams hit the car itself: masked by --set mask_angle=1.66 --set mask_range=0.8" in found.remarks
    assert found.driven.setup.get("mask_angle") == 1.66
    assert drive(seen, mask_body=False).body is None
    own = load_setup("base").with_values({"mask_range": 0.2})
    assert run_replay(seen, own, load_car("default")).body is None


def test_the_cars_body_is_found_on_both_sides_wherever_the_scan_begins(corridor):
    full, half = np.full(720, 3.0, dtype=np.float32), 360
    full[half - 215 : half - 205] = full[half + 206 : half + 216] = 0.5
    for seam in (0, 180, half, 600):
        headers = np.tile([-np.pi + seam * np.pi / 360, np.pi / 360, 0.0, 0.02, 30.0], (len(corridor), 1))
        found = find_body(replace(corridor, ranges=[np.roll(full, -seam)] * len(corridor), headers=headers),
                          load_setup("base"))  # fmt: skip
        assert found is not None
        assert found.beams == 20


def test_a_body_inside_the_setups_mask_needs_none(corridor):
    assert find_body(corridor, load_setup("base")) is None
    assert find_body(with_body(corridor, slice(0, 10), 0.2), load_setup("base")) is None
    # At a standstill all returns are constant, like those of the car.
    still = replace(corridor, states=np.zeros_like(corridor.states))
    assert find_body(with_body(still, slice(0, 12), 0.9), load_setup("base")) is None


def test_the_lasers_place_is_the_cars_unless_the_setup_says_another(corridor):
    seen = replace(corridor, laser=Mount(0.15, 0.0, 0.0, False))
    car = drive(seen).car
    assert car.core.get("geometry", "laser_x") == 0.15
    assert load_setup("base").params(car.core).get("car", "laser_x") == 0.15
    own = load_setup("base").with_assignments(["car.laser_x=0.2"])
    assert own.params(run_replay(seen, own, load_car("default")).car.core).get("car", "laser_x") == 0.2
    with pytest.raises(InputError, match=r"LiDAR: .*laser_x.*--laser"):
        drive(replace(corridor, laser=Mount(1.9, 0.0, 0.0, False)))


@pytest.fixture(scope="module")
def lap(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Four seconds of a race on a winding track, with a LiDAR without sweep time."""
    path = tmp_path_factory.mktemp("lap") / "a.mcap"
    car = load_car("default")
    car.core.set("lidar", "sweep_time", 0.0)
    race(load_track("arena"), "base", car, laps=1, record=path)
    return load_recording(path).between(0.0, 4.0)


MOUNTINGS = {
    "upside down": (0.27, 0.0, 0.0, 180.0),
    "turned by a quarter": (0.27, 0.0, 90.0, 0.0),
    "cable to the rear": (0.27, 0.0, 180.0, 0.0),
    "both": (0.27, 0.0, -120.0, 180.0),
}


@pytest.mark.parametrize("mounting", MOUNTINGS.values(), ids=MOUNTINGS.keys())
def test_however_the_laser_is_mounted_the_commands_are_the_same(lap, tmp_path, mounting):
    plain = drive(
        load_recording(bags.as_mounted(lap, (0.27, 0.0, 0.0, 0.0), tmp_path / "plain")), mask_body=False
    ).driven
    path = bags.as_mounted(lap, mounting, tmp_path / "mounted")
    other = drive(load_recording(path), mask_body=False).driven
    assert np.percentile(np.abs(other.steering_angle - plain.steering_angle), 95) < 0.02
    assert np.percentile(np.abs(other.speed - plain.speed), 95) < 0.1
    given = Topics(laser=parse_laser(",".join(map(str, mounting))))
    without = load_recording(bags.as_mounted(lap, mounting, tmp_path / "without", tf=False), given)
    assert np.array_equal(drive(without, mask_body=False).driven.steering_angle, other.steering_angle)


def test_explain_and_replay_take_the_lasers_option(cli, lap, tmp_path):
    path = bags.as_mounted(lap, MOUNTINGS["both"], tmp_path / "a", tf=False)
    found = cli("replay", path, "--laser", "0.27,0,-120,180", "--json").json
    assert found["sources"]["laser"] == "--laser"
    assert found["recorded"]["steering_angle"]["median"] < 0.05
    assert "rotated by -120°, upside down" in cli("explain", path, "--laser", "0.27,0,-120,180", "--scan", 9).err
    ran = cli("replay", path, "--laser", "here")
    assert ran.code == 2
    assert "--laser here: expected X,Y,YAW[,ROLL]" in ran.err


def test_steering_in_degrees_is_not_compared_with(cli, tmp_path):
    items = bags.entries()
    for item in items:
        if item.topic == "/drive":
            item.message.drive.steering_angle = 5.0
    path = bags.write_rosbag2(tmp_path / "a", items)
    found = cli("replay", path, "--json", "--plot", "a.png").json
    assert found["recorded"]["steering_angle"] == {"median": None, "p95": None}
    assert found["recorded"]["speed"]["median"] is not None
    assert "steering angle not known, speed difference 0" in cli("replay", path).out


def test_poses_of_odometry_are_said_to_be_none_of_a_map(cli, tmp_path):
    items = bags.entries()
    for item in items:
        if item.topic == "/odom":
            item.message.header.frame_id = "/odom"
    ran = cli("replay", bags.write_rosbag2(tmp_path / "a", items), "--map", "oval")
    assert ran.code == 2
    assert "its poses are from odometry (frame 'odom') and cannot be compared" in ran.err


def test_a_jump_is_measured_after_the_cars_own_motion():
    line = np.column_stack([np.arange(0.0, 5.0, 0.1), np.zeros(50)])
    nothing = np.zeros((0, 2))
    state, dt = np.array([2.0, 0.0, 0.0]), 0.1
    steady = Continuity()
    assert np.isnan(steady.add(line, nothing, nothing, state, dt)[0])
    assert steady.add(line, nothing, nothing, state, dt)[0] == pytest.approx(0.0, abs=1e-12)
    assert steady.add(line + np.array([0.0, 0.3]), nothing, nothing, state, dt)[0] == pytest.approx(0.3)
    # A rotation of the car by 0.1 rad moves a static line by 1.5 m times 0.1.
    turning = Continuity()
    turning.add(line, nothing, nothing, np.array([0.0, 1.0, 0.0]), dt)
    c, s = np.cos(0.1), np.sin(0.1)
    turned = line @ np.array([[c, -s], [s, c]])
    assert turning.add(turned, nothing, nothing, np.array([0.0, 1.0, 0.0]), dt)[0] == pytest.approx(0.0, abs=1e-9)
    assert turning.add(turned, nothing, nothing, np.array([0.0, 1.0, 0.0]), dt)[0] == pytest.approx(0.15, abs=0.01)
    assert np.isnan(turning.add(turned, nothing, nothing, state, 1.0)[0])


def test_a_wall_that_changes_its_side_is_counted():
    left = np.column_stack([np.arange(0.0, 3.0, 0.15), np.full(20, 1.0)])
    right = left - (0.0, 2.0)
    path, state = np.zeros((0, 2)), np.array([1.0, 0.0, 0.0])
    walls = Continuity()
    assert not walls.add(path, left, right, state, 0.025)[1]
    assert not walls.add(path, left, right, state, 0.025)[1]
    assert walls.add(path, left[:10], np.vstack([right, left[10:]]), state, 0.025)[1]
    assert not walls.add(path, left[:10], np.vstack([right, left[10:]]), state, 0.025)[1]


def test_scans_of_changing_size_are_driven_through(tmp_path):
    items = bags.entries(60)
    for i, item in enumerate(items):
        if item.topic == "/scan" and i > 60:
            items[i] = item._replace(message=bags.scan(item.time, bags.corridor(541, seed=i)))
    recording = load_recording(bags.write_rosbag2(tmp_path / "a", items))
    assert drive(recording).to_dict()["statuses"] == {"ok": 60}


@pytest.mark.parametrize("driver", ["gap", "disparity", "pid"])
def test_other_drivers_drive_recordings_too(cli, bag, driver):
    found = cli("replay", bag, "--driver", driver, "--against", "base", "--plot", "a.png", "--json").json
    assert found["driver"] == driver
    assert found["statuses"] == {"ok": 120}
    assert found["sides"] == {"both": None, "one": None, "none": None}
    assert found["against"]["sides"]["both"] == 1.0
    assert Path("a.png").read_bytes().startswith(PNG)
    assert driver in cli("replay", bag, "--driver", driver).out
    assert cli("explain", bag, "--driver", driver, "--scan", 50).code == 0


DENSE = {"straight_1_speed_1": 707, "sinside_corner_1_speed_1": 605}


@needs_scans
@pytest.mark.parametrize("name", DENSE)
def test_real_corridors_are_planned_through(name):
    recording = load_recording(SCANS / name / "rosbag2", Topics(drive="/vesc/low_level/ackermann_cmd"))
    found = drive(recording, "sure")
    assert found.body is None  # the visible part of this car is within the mask of every setup
    measured = found.to_dict()
    assert measured["scans"] == DENSE[name]
    assert measured["available"]["1"] >= 0.99
    assert measured["jump"]["p95"] <= 0.20
    assert measured["jump"]["big"] <= 0.07


@needs_scans
@pytest.mark.parametrize("name", ["germany2022", "hangar12", "rollcage"])
def test_real_race_tracks_are_planned_through(name):
    found = drive(load_recording(SCANS / name / f"{name}.npz"), "sure").to_dict()
    assert found["statuses"]["ok"] >= 0.95 * found["scans"]
    assert found["sides"]["none"] == 0.0
    assert found["available"]["2"] > 0.9


def test_names_that_are_no_utf8_are_drawn_and_logged_with_question_marks(tmp_path, bag):
    name = tmp_path / os.fsdecode(b"n\xff $x^$.db3")
    name.write_bytes(next(bag.glob("*.db3")).read_bytes())
    recording = load_recording(name).between(0.0, 0.5)
    drive(recording, record=tmp_path / "a.mcap").plot(tmp_path / "a.png")
    about = load_recording(tmp_path / "a.mcap").about
    assert about is not None
    assert about.what == "replay of n? $x^$"
    plot_step(explain_recording(recording, load_setup("base"), load_car("default"), 5), tmp_path / "b.png")
    oval = load_track("oval")
    race(replace(oval, name=name.stem), "base", laps=1).plot(tmp_path / "c.png")
    assert all((tmp_path / picture).read_bytes().startswith(PNG) for picture in ("a.png", "b.png", "c.png"))


GYRO = 0.04


def with_imu(
    folder: Path,
    acceleration: tuple[float, float] | None,
    gyro: float | None = GYRO,
    count: int = 60,
    topic: str | None = "/imu",
) -> Recording:
    """The corridor with a wheel speed of 2 m/s and an IMU whose gyro has a bias, for the first `count` scans."""
    messages = [
        bags.Entry("/imu", bags.IMU, bags.nanoseconds(i), bags.imu(bags.nanoseconds(i), gyro, acceleration))
        for i in range(count)
    ]
    return load_recording(bags.write_rosbag2(folder / "a", bags.entries() + messages), Topics(imu=topic))


def test_the_estimate_replaces_the_recorded_state(tmp_path):
    recording = with_imu(tmp_path, (0.0, 0.0))
    assert recording.acceleration is not None and recording.acceleration.shape == (60, 2)
    found = drive(recording, estimated=True)
    assert found.recording.sources["speed"] == "state estimate"
    assert np.abs(found.recording.speed - bags.SPEED)[20:].max() < 0.05
    assert not np.array_equal(found.recording.states, recording.states)
    assert not np.array_equal(found.driven.steering_angle, drive(recording).driven.steering_angle)


def test_an_imu_without_an_accelerometer_has_no_acceleration(tmp_path):
    assert with_imu(tmp_path, None).acceleration is None


def test_an_imu_without_a_gyro_has_no_yaw_rate(tmp_path):
    recording = with_imu(tmp_path, (0.0, 0.0), None)
    assert recording.gyro is None
    assert recording.sources["yaw_rate"] == "odometry (/odom)"
    assert any("measures no yaw rate" in remark for remark in recording.remarks)


def test_the_estimate_takes_the_yaw_rate_of_the_imu_not_that_of_the_odometry(tmp_path):
    """As in the driving node: the odometry's is calculated from speed and steering angle."""
    recording = with_imu(tmp_path, (0.0, 0.0), topic=None)
    assert recording.sources["yaw_rate"] == "odometry (/odom)"
    assert np.allclose(readings_of(recording)[:, READINGS.index("yaw_rate")], GYRO)


def test_after_an_imu_has_failed_its_last_values_are_no_measurements(tmp_path):
    readings = readings_of(with_imu(tmp_path, (3.0, 0.0), count=20))
    for name in ("yaw_rate", "acceleration_x", "acceleration_y"):
        column = readings[:, READINGS.index(name)]
        assert np.all(np.isfinite(column[:20])), name
        assert np.all(np.isnan(column[-10:])), name


def test_readings_follow_the_columns_of_the_table(tmp_path, monkeypatch):
    recording = with_imu(tmp_path, (1.0, 2.0))
    known = readings_of(recording)
    monkeypatch.setattr("firstlap.evaluation.replay.estimated.READINGS", READINGS[::-1])
    assert np.array_equal(readings_of(recording), known[:, ::-1], equal_nan=True)
    with pytest.raises(KeyError, match="no such column: wheels"):
        in_columns(READINGS, {"wheels": np.zeros(1)}, 1)


def test_without_wheel_speed_there_is_nothing_to_estimate(tmp_path):
    path = bags.write_rosbag2(tmp_path / "a", bags.entries(odom=False))
    with pytest.raises(InputError, match="no wheel speed to estimate the state from: its speed is from commands"):
        drive(load_recording(path), estimated=True)
