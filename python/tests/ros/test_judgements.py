"""Checks of messages, mountings and live topics, without ROS."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap.cli import run
from firstlap.common.errors import InputError
from firstlap.drivers.driving import Driving
from firstlap.perception.frames import Frames, mount_of
from firstlap.perception.scan import Mount
from firstlap.ros import require_ros
from firstlap.ros.conversions import judged, sweep_of, to_scan
from firstlap.ros.periods import BOUNDS
from firstlap.ros.preflight import (
    Check,
    Sample,
    check_agreement,
    check_drive,
    check_forward,
    check_mount,
    check_rate,
    check_scale,
    check_scan,
    check_stamps,
    check_turn,
    turn_between,
)
from firstlap.ros.sim_topics import gym_names, our_names
from firstlap.sim.lidar import Lidar


def scan_message(ranges: Any, **changes: Any) -> Any:
    """A message like sensor_msgs/LaserScan."""
    values = np.ascontiguousarray(ranges, dtype=np.float32)
    step = 1.5 * math.pi / (len(values) - 1) if len(values) > 1 else 0.1
    message = {
        "angle_min": -0.75 * math.pi,
        "angle_max": -0.75 * math.pi + step * (len(values) - 1),
        "angle_increment": step,
        "time_increment": 0.0,
        "range_min": 0.06,
        "range_max": 30.0,
        "ranges": values,
    }
    return SimpleNamespace(**{**message, **changes})


AHEAD = Mount(0.27, 0.0, 0.0, False)


def reason_of(message: Any, mount: Mount = AHEAD, period: float = 0.025) -> str:
    """The reason why the node rejects a scan."""
    return judged(message, mount, period)[1].reason


def test_a_scan_that_is_no_measurement_is_named_by_the_judge_of_all() -> None:
    good = np.ones(100)
    assert reason_of(scan_message(good)) == ""
    for spelled in (math.nan, math.inf, 0.0):
        assert "0 of 100 beams return" in reason_of(scan_message(np.full(100, spelled)))
    assert "angle_max" in reason_of(scan_message(good, angle_max=9.0))
    assert "finite" in reason_of(scan_message(good, angle_min=math.nan))
    assert "degrees" in reason_of(scan_message(good, angle_min=-135.0, angle_increment=2.7, angle_max=132.3))
    off_by_one = scan_message(np.ones(1080), angle_increment=4.7 / 1080, angle_min=-2.35, angle_max=2.35)
    assert reason_of(off_by_one) == "", "as f1tenth_gym_ros has it"
    behind = scan_message(good, angle_min=-0.5, angle_increment=0.01, angle_max=0.49)
    assert reason_of(behind) == ""
    assert "no beam points ahead" in reason_of(behind, Mount(0.27, 0.0, math.pi, False))


def test_a_sweep_longer_than_the_period_is_worth_a_remark_and_no_reason() -> None:
    scan, judgment = judged(scan_message(np.ones(100), time_increment=0.01), AHEAD, 0.1)
    assert (judgment.reason, len(scan.ranges)) == ("", 100)
    assert any("time_increment" in remark for remark in judgment.remarks)


def test_a_laser_upside_down_or_turned_gives_the_same_points() -> None:
    ranges = np.linspace(1.0, 4.0, 100, dtype=np.float32)
    plain = to_scan(scan_message(ranges), Mount(0.27, 0.0, 0.0, False))
    hung = to_scan(scan_message(ranges[::-1]), Mount(0.27, 0.0, 0.0, True))

    def points(scan: Any) -> Any:
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        order = np.argsort(angles)
        return np.column_stack([angles, scan.ranges])[order]

    np.testing.assert_allclose(points(hung), points(plain), atol=1e-5)
    turned = to_scan(scan_message(ranges), Mount(0.27, 0.0, 0.5, False))
    assert turned.angle_min == pytest.approx(plain.angle_min + 0.5)


def test_a_laser_upside_down_drives_the_same_way(arena: firstlap.Track) -> None:
    x, y = (float(value) for value in arena.to_arrays()["centerline"][0])
    seen = Lidar(arena).scan(x, y, 0.05)
    commands = []
    for ranges, mount in ((seen, Mount(0.27, 0.0, 0.0, False)), (seen[::-1], Mount(0.27, 0.0, 0.0, True))):
        driving = Driving(firstlap.load_setup("sure"))
        commands = [*commands, driving.step(to_scan(scan_message(ranges), mount), 2.0, 0.0, 0.0, 0.025)]
    assert commands[0].status == "ok"
    assert commands[1].steering_angle == pytest.approx(commands[0].steering_angle, abs=0.01)
    assert commands[1].speed == pytest.approx(commands[0].speed, abs=0.05)


def transform(parent: str, child: str, x: float, roll: float = 0.0, yaw: float = 0.0) -> Any:
    """A message like geometry_msgs/TransformStamped, with roll or yaw."""
    turn = SimpleNamespace(x=math.sin(roll / 2), y=0.0, z=math.sin(yaw / 2), w=math.cos(roll / 2 + yaw / 2))
    place = SimpleNamespace(translation=SimpleNamespace(x=x, y=0.0, z=0.1), rotation=turn)
    return SimpleNamespace(header=SimpleNamespace(frame_id=parent), child_frame_id=child, transform=place)


def test_the_lasers_place_is_found_through_the_tree_and_a_bad_one_refused() -> None:
    frames = Frames()
    frames.add(
        SimpleNamespace(transforms=[transform("base_link", "deck", 0.2), transform("deck", "laser", 0.07, yaw=0.3)])
    )
    frames.add(SimpleNamespace(transforms=[transform("odom", "base_link", 5.0)]))
    place = frames.find("base_link", "laser")
    assert place is not None
    mount = mount_of(place)
    assert (mount.x, mount.yaw, mount.upside_down) == (pytest.approx(0.27), pytest.approx(0.3), False)
    assert frames.find("base_link", "nowhere") is None
    frames.add(SimpleNamespace(transforms=[transform("base_link", "hung", 0.2, roll=math.pi)]))
    hung = frames.find("base_link", "hung")
    assert hung is not None
    assert mount_of(hung).upside_down
    frames.add(SimpleNamespace(transforms=[transform("base_link", "leaning", 0.2, roll=0.5)]))
    leaning = frames.find("base_link", "leaning")
    assert leaning is not None
    with pytest.raises(ValueError, match="is tilted by 29 degrees"):
        mount_of(leaning)


def turn_of(roll: float, pitch: float, yaw: float) -> tuple[Any, Any]:
    """The rotation as quaternion and as (3, 3): roll, then pitch, then yaw, as in ROS."""

    def about(axis: int, angle: float) -> Any:
        c, s = math.cos(angle), math.sin(angle)
        found = np.eye(3)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        found[i, i] = found[j, j] = c
        found[i, j], found[j, i] = -s, s
        return found

    cr, sr, cp, sp = math.cos(roll / 2), math.sin(roll / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    turn = SimpleNamespace(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )
    return turn, about(2, yaw) @ about(1, pitch) @ about(0, roll)


@pytest.mark.parametrize("roll", [0.0, math.pi, 0.1])
@pytest.mark.parametrize("pitch", [0.0, math.pi])
@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi, math.pi, -2.0])
def test_a_beam_points_where_the_transform_turns_it(roll: float, pitch: float, yaw: float) -> None:
    quaternion, turn = turn_of(roll, pitch, yaw)
    place = SimpleNamespace(translation=SimpleNamespace(x=0.2, y=-0.05, z=0.1), rotation=quaternion)
    header = SimpleNamespace(frame_id="base_link")
    frames = Frames()
    frames.add(SimpleNamespace(transforms=[SimpleNamespace(header=header, child_frame_id="laser", transform=place)]))
    found = frames.find("base_link", "laser")
    assert found is not None
    mount = mount_of(found)
    assert mount.upside_down == ((roll == math.pi) != (pitch == math.pi))
    for angle in np.linspace(-3.0, 3.0, 7):
        x, y, _ = turn @ [math.cos(angle), math.sin(angle), 0.0]
        first, _ = mount.turned(float(angle), 0.01)
        assert math.remainder(math.atan2(y, x) - first, 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)


def test_a_sweep_that_cannot_be_true_takes_no_time() -> None:
    message = SimpleNamespace(ranges=np.ones(101, dtype=np.float32), time_increment=1e-4)
    assert sweep_of(message, 0.025) == pytest.approx(0.01)
    message.time_increment = 1e-3
    assert sweep_of(message, 0.1) == pytest.approx(0.1), "a full circle takes a whole period"
    assert sweep_of(message, 0.025) == 0.0
    assert sweep_of(message, 0.0) == pytest.approx(0.1), "the period is not known"
    message.time_increment = -1e-4
    assert sweep_of(message, 0.025) == 0.0


def test_parameters_change_while_driving_and_a_bad_one_changes_nothing() -> None:
    driving = Driving(firstlap.load_setup("sure"))
    core = driving.handle.core
    driving.change({"velocity_profile.v_max": 3.0})
    assert driving.handle.core is core, "the driver keeps its memory"
    with pytest.raises(InputError, match="v_min"):
        driving.change({"velocity_profile.v_max": 1.0})
    with pytest.raises(InputError, match="allowed"):
        driving.change({"velocity_profile.v_max": 99.0})
    assert driving.setup.get("v_max") == 3.0


def test_the_laser_may_sit_only_where_the_method_has_it() -> None:
    driving = Driving(firstlap.load_setup("sure"))
    driving.mount(Mount(0.1, 0.0, 0.0, False))
    driving.mount(Mount(0.27, 0.12, 0.0, False))
    with pytest.raises(InputError, match="laser_x"):
        driving.mount(Mount(3.0, 0.0, 0.0, False))
    with pytest.raises(InputError, match="laser_y"):
        driving.mount(Mount(0.27, -0.9, 0.0, False))


@pytest.mark.parametrize("turn", [0.5, -0.5])
def test_a_turn_between_two_scans_is_found_with_its_sign(arena: firstlap.Track, turn: float) -> None:
    lidar = Lidar(arena)
    x, y = (float(value) for value in arena.to_arrays()["centerline"][0])
    before, after = lidar.scan(x, y, 0.0), lidar.scan(x, y, turn)
    step = float(lidar.angles[1] - lidar.angles[0])
    assert turn_between(before, after, step, 1.2) == pytest.approx(turn, abs=0.02)


def rate_of(arrivals: list[float], timeout: float = 0.0) -> Check:
    """The rate check of preflight for scans with these times of arrival [s]."""
    return check_rate("scan", "/scan", Sample(arrivals, [], None), timeout, BOUNDS["scan"])


def test_preflight_says_what_is_wrong() -> None:
    steady = [0.025 * i for i in range(40)]
    assert check_rate("scan", "/scan", Sample(steady, [], None), 0.0, BOUNDS["scan"]).good
    assert "nothing on /scan" in check_rate("scan", "/scan", Sample([], [], None), 0.0, BOUNDS["scan"]).said
    assert "gap of 1000 ms" in check_rate("scan", "/scan", Sample([*steady, 1.975], [], None), 0.0, BOUNDS["scan"]).said
    assert check_scan(*judged(scan_message(np.ones(100)), AHEAD, 0.025)).good
    assert check_scan(*judged(scan_message(np.full(100, np.inf)), AHEAD, 0.025)).good is False
    assert check_mount(Mount(0.27, 0.12, 0.0, False), "base_link").said.startswith(
        "0.27 m ahead of base_link, 0.12 m left"
    )
    assert "laser_y" in check_mount(Mount(0.27, 0.9, 0.0, False), "base_link").said
    assert check_drive("/drive", 0, []).good is False
    assert check_drive("/drive", 1, ["joy"]).good is False
    assert check_forward(0.7, 0.7).good
    assert "wrong sign" in check_forward(-0.7, 0.7).said
    assert "enabled" in check_forward(0.0, 0.7).said
    assert check_scale(0.7, 0.72, 0.68).good
    assert check_scale(0.7, 0.7, None).good
    assert check_scale(0.7, 0.7, 0.0).good, "on a stand"
    assert "+20 %: calibrate" in check_scale(0.7, 0.84, None).said
    assert "odometry reads +20 %" in check_scale(0.7, 0.84, 0.7).said
    assert "drives +20 %" in check_scale(0.7, 0.84, 0.84).said
    assert "wrong sign" in check_scale(0.7, -0.7, 0.7).said
    assert check_agreement((), ()).good is None
    assert check_agreement((), ("the scans",)).good
    assert check_agreement(("speed: no",), ("the scans",)) == ("odometry agrees", False, "speed: no")
    assert check_turn(0.6, 0.58).good
    assert "yaw rate has the wrong sign" in check_turn(-0.6, 0.58).said
    assert "wrong direction" in check_turn(0.6, -0.6).said
    assert check_turn(0.0, 0.0).good is None


def test_names_of_several_cars() -> None:
    assert [one.scan for one in our_names(2, "")] == ["car1/scan", "car2/scan"]
    assert our_names(1, "")[0].base_frame == "base_link"
    with pytest.raises(InputError, match="3 cars"):
        our_names(3, "a,b")
    ego, opponent = gym_names(2)
    assert (ego.odom, ego.others, opponent.drive) == (
        "ego_racecar/odom",
        (("ego_racecar/opp_odom", 1),),
        "opp_drive",
    )
    with pytest.raises(InputError, match="one or two"):
        gym_names(3)


@pytest.mark.parametrize("command", ["drive", "sim", "latency", "preflight", "go", "resume", "stop", "set v_max 3"])
def test_without_ros_a_command_says_in_one_line_how_to_get_it(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("firstlap.ros.NEEDED", {"no_such_module": "firstlap[ros]"})
    with pytest.raises(InputError, match="make ros"):
        require_ros()
    assert run(command.split()) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ROS 2 is not available")
    assert error.count("\n") == 1


@pytest.mark.parametrize("rate", [5.0, 7.0, 10.0, 40.0])
def test_preflight_lets_a_slow_lidar_drive_as_the_node_does_and_names_one_that_is_too_slow(rate: float) -> None:
    steady = [i / rate for i in range(20)]
    assert rate_of(steady).good
    assert rate_of(steady, 0.05).good == (rate == 40.0)
    assert rate_of([0.4 * i for i in range(20)]).said == "/scan at 2.5 Hz; with a timeout of 0.5 s it needs 3.0 Hz"


def test_preflight_takes_stamps_as_the_node_does() -> None:
    assert check_stamps("clock", Sample([], [0.12], None), 0.15).good
    assert check_stamps("clock", Sample([], [0.21], None), 0.15, 0.1).good, "stamped at the first beam of a long sweep"
    assert check_stamps("clock", Sample([], [0.0], None), 0.15, 0.2).good, "stamped at its last"
    assert "0.21 s old" in check_stamps("clock", Sample([], [0.21], None), 0.15).said
    assert check_stamps("clock", Sample([], [9.0], None), 0.0).good


def test_a_laser_beside_the_middle_drives_the_same_way(arena: firstlap.Track) -> None:
    x, y = (float(value) for value in arena.to_arrays()["centerline"][0])
    commands = []
    for aside in (0.0, 0.15):
        driving = Driving(firstlap.load_setup("sure"))
        driving.mount(Mount(0.27, aside, 0.0, False))
        seen = Lidar(arena).scan(x + 0.27, y + aside, 0.0)
        commands.append(driving.step(to_scan(scan_message(seen), AHEAD), 2.0, 0.0, 0.0, 0.025))
    assert commands[0].status == "ok"
    assert commands[1].steering_angle == pytest.approx(commands[0].steering_angle, abs=0.02)
