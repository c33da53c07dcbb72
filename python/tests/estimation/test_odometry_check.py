"""The odometry check: every kind of contradiction with poses, scans or commands is reported, and nothing else."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from firstlap.estimation.odometry_check import (
    COMMANDS,
    POSES,
    SCANS,
    SPEED,
    STANDING,
    YAW_RATE,
    Odometry,
    Pair,
    Steps,
    gross,
    judge,
)

STEP = 0.1
"""[s] Duration of a scan step."""
PERIOD = 0.02
"""[s] Period of the odometry."""


def slalom(speed: float = 1.5, seconds: float = 6.0, turn: float = 1.2, heading: float = 0.0) -> tuple[Odometry, Steps]:
    """Consistent data of a car on a winding path at constant speed."""
    times = np.arange(0.0, seconds + 0.5 * PERIOD, PERIOD)
    yaw_rate = turn * np.sin(1.5 * times)
    yaw = heading + np.concatenate([[0.0], np.cumsum(0.5 * (yaw_rate[1:] + yaw_rate[:-1]) * PERIOD)])
    twist = np.column_stack([np.full(len(times), speed), np.zeros(len(times)), yaw_rate])
    way = [np.concatenate([[0.0], np.cumsum(speed * PERIOD * f(yaw[:-1]))]) for f in (np.cos, np.sin)]
    begins = np.arange(0.3, seconds - 0.5, STEP)
    turns = np.interp(begins + STEP, times, yaw) - np.interp(begins, times, yaw)
    motion = np.column_stack([np.full(len(begins), speed * STEP), np.zeros(len(begins)), turns])
    steps = Steps(begins, begins + STEP, motion, np.full(len(begins), speed))
    return Odometry(times, twist, np.column_stack([*way, yaw])), steps


def scaled(odometry: Odometry, forward: float = 1.0, turn: float = 1.0) -> Odometry:
    """The twist with wrong units, wrong signs, or zero."""
    return replace(odometry, twist=odometry.twist * np.array([forward, 1.0, turn]))


def without_poses(odometry: Odometry) -> Odometry:
    """Poses that the driver never fills in."""
    return replace(odometry, poses=None)


def in_the_frame_of_the_poses(odometry: Odometry) -> Odometry:
    """The twist in the map frame, as some drivers publish it."""
    assert odometry.poses is not None
    speed, yaw = odometry.twist[:, 0], odometry.poses[:, 2]
    return replace(odometry, twist=np.column_stack([speed * np.cos(yaw), speed * np.sin(yaw), odometry.twist[:, 2]]))


def blind(steps: Steps) -> Steps:
    """A hall without returns in the scans."""
    return replace(steps, motion=np.full_like(steps.motion, math.nan))


def kinds(verdicts: Any) -> dict[Pair, str]:
    """{pair: kind} of all contradictions."""
    return {pair: found.kind for pair, found in verdicts.items() if found is not None}


def test_honest_odometry_is_compared_with_everything_and_agrees() -> None:
    verdicts = judge(*slalom())
    everything = {Pair(SPEED, SCANS), Pair(SPEED, POSES), Pair(SPEED, COMMANDS), Pair(YAW_RATE, SCANS)}
    assert everything | {Pair(YAW_RATE, POSES)} == set(verdicts)
    assert kinds(verdicts) == {}
    assert gross(verdicts) == ""


@pytest.mark.parametrize("poses", [True, False], ids=["poses", "no poses"])
@pytest.mark.parametrize("scans", [True, False], ids=["scans", "no scans"])
@pytest.mark.parametrize(
    ("forward", "turn", "kind", "words"),
    [
        (-1.0, 1.0, "sign", "says -1.50 m/s"),
        (3.6, 1.0, "unit", "km/h instead of m/s"),
        (0.0, 1.0, "zero", "it stands at 0"),
        (2.0, 1.0, "scale", "a factor of 2.00"),
        (1.0, math.degrees(1.0), "unit", "degrees per second instead of radians"),
        (1.0, -1.0, "sign", "the wrong sign"),
        (1.0, 0.0, "zero", "it stands at 0"),
    ],
)
def test_each_kind_is_named_by_whatever_there_is_to_compare_with(
    forward: float, turn: float, kind: str, words: str, scans: bool, poses: bool
) -> None:
    odometry, steps = slalom()
    odometry = scaled(odometry if poses else without_poses(odometry), forward, turn)
    verdicts = judge(odometry, steps if scans else blind(steps))
    quantity = SPEED if forward != 1.0 else YAW_RATE
    found = {pair: one for pair, one in verdicts.items() if one is not None and pair.reference != COMMANDS}
    wanted = {Pair(quantity, SCANS)} if scans else set()
    wanted |= {Pair(quantity, POSES)} if poses else set()
    assert set(found) == wanted
    assert all(one.kind == kind and words in one.text and one.gross for one in found.values())
    assert bool(gross(verdicts)) == bool(wanted) or forward not in (1.0, 0.0), "commands may tell too"


@pytest.mark.parametrize("heading", [0.6, 1.6, 3.1, -2.0])
def test_a_twist_in_the_frame_of_the_map_is_named_by_the_poses(heading: float) -> None:
    odometry, steps = slalom(heading=heading)
    verdicts = judge(in_the_frame_of_the_poses(odometry), steps)
    assert kinds(verdicts)[Pair(SPEED, POSES)] == "frame"
    assert "frame of the car" in gross(verdicts)
    assert kinds(judge(in_the_frame_of_the_poses(odometry), blind(steps)))[Pair(SPEED, POSES)] == "frame"


def test_a_twist_in_the_frame_of_the_map_is_named_by_the_scans_where_there_are_no_poses() -> None:
    odometry, steps = slalom(heading=1.6)
    verdicts = judge(without_poses(in_the_frame_of_the_poses(odometry)), steps)
    assert kinds(verdicts)[Pair(SPEED, SCANS)] == "frame"
    assert gross(verdicts)


@pytest.mark.parametrize("error", [0.85, 0.9, 1.1, 1.15])
def test_a_small_error_of_scale_is_no_contradiction(error: float) -> None:
    odometry, steps = slalom()
    assert kinds(judge(scaled(odometry, error, error), steps)) == {}


@pytest.mark.parametrize("late", [0.0, 0.05, 0.2, 0.3])
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_delay_and_noise_are_no_contradiction_even_when_the_car_sets_off(late: float, noise: float) -> None:
    rng = np.random.default_rng(3)
    times = np.arange(0.0, 8.0, PERIOD)
    speed = np.clip(4.0 * (times - 2.0), 0.0, 6.0)
    begins = np.arange(0.3, 7.0, STEP)
    way = np.concatenate([[0.0], np.cumsum(speed[:-1] * PERIOD)])
    forward = np.interp(begins + STEP, times, way) - np.interp(begins, times, way)
    motion = np.column_stack([forward, np.zeros((len(begins), 2))]) + rng.normal(0.0, 0.004, (len(begins), 3))
    steps = Steps(begins, begins + STEP, motion, np.full(len(begins), 6.0))
    measured = np.interp(times - late, times, speed) + rng.normal(0.0, noise, len(times))
    odometry = Odometry(times, np.column_stack([measured, np.zeros((len(times), 2))]))
    for last in range(1, len(steps) + 1):
        assert gross(judge(odometry, steps.part(0, last))) == "", f"after {last} steps"


def test_degrees_per_second_are_seen_before_the_car_has_turned() -> None:
    odometry, steps = slalom(turn=0.1)
    assert kinds(judge(odometry, steps)) == {}
    assert "degrees per second" in gross(judge(scaled(odometry, turn=math.degrees(1.0)), steps))


def test_a_pose_that_jumps_is_no_contradiction() -> None:
    odometry, steps = slalom()
    assert odometry.poses is not None
    poses = odometry.poses.copy()
    poses[200:, :2] += (3.0, -4.0)
    assert kinds(judge(replace(odometry, poses=poses), steps)) == {}


def test_where_twist_and_scans_agree_wrong_poses_are_a_remark() -> None:
    odometry, steps = slalom()
    assert odometry.poses is not None
    verdicts = judge(replace(odometry, poses=odometry.poses * np.array([0.3, 0.3, 1.0])), steps)
    found = verdicts[Pair(SPEED, POSES)]
    assert found is not None
    assert not found.gross
    assert "the scans agree with the twist" in found.text


def test_a_car_that_is_faster_than_it_is_told_is_remarked_where_the_scans_say_so_too() -> None:
    odometry, steps = slalom(speed=3.0)
    told = replace(steps, commands=np.full(len(steps), 1.0))
    assert not gross(judge(odometry, told))
    assert kinds(judge(odometry, told)) == {Pair(SPEED, COMMANDS): "commands"}
    assert "commands say 1.00 m/s" in gross(judge(without_poses(odometry), blind(told)))


def standing(speed: float, yaw_rate: float, command: float) -> dict[Pair, Any]:
    """Verdicts while the scans show no motion."""
    times = np.arange(0.0, 4.0, PERIOD)
    begins = np.arange(0.3, 3.0, STEP)
    steps = Steps(begins, begins + STEP, np.zeros((len(begins), 3)), np.full(len(begins), command))
    return judge(Odometry(times, np.tile([speed, 0.0, yaw_rate], (len(times), 1))), steps)


def test_odometry_that_moves_while_the_scans_stand_is_gross_unless_the_wheels_were_told_to_turn() -> None:
    assert kinds(standing(0.0, 0.0, math.nan)) == {}
    assert "while the scans do not move" in gross(standing(0.8, 0.0, math.nan))
    assert "rad/s" in gross(standing(0.0, 2.0, math.nan))
    on_a_stand = standing(0.8, 0.0, 0.8)
    assert not gross(on_a_stand)
    assert "on a stand" in on_a_stand[Pair(SPEED, STANDING)].text
    offset = standing(0.15, 0.2, math.nan)
    assert not gross(offset), "an offset is a remark"
    assert {Pair(SPEED, STANDING), Pair(YAW_RATE, STANDING)} == set(kinds(offset))


@pytest.mark.parametrize(("angle", "kind"), [(0.5 * math.pi, "direction"), (math.pi, "sign")])
def test_scans_that_go_another_way_may_be_a_laser_that_is_turned(angle: float, kind: str) -> None:
    odometry, steps = slalom()
    c, s = math.cos(angle), math.sin(angle)
    motion = steps.motion @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    found = judge(odometry, replace(steps, motion=motion))[Pair(SPEED, SCANS)]
    assert found is not None
    assert found.kind == kind
    assert "LiDAR" in found.text


def test_nothing_is_judged_without_motion_and_without_odometry() -> None:
    odometry, steps = slalom()
    assert judge(odometry, steps.part(0, 0)) == {}
    assert judge(Odometry(np.zeros(0), np.zeros((0, 3))), steps) == {}
    assert judge(odometry, steps.part(0, 3)) == {}


def test_a_standing_car_that_is_put_elsewhere_says_nothing() -> None:
    """One scan step is large and all others are noise: without the jump there is no motion to compare."""
    odometry, steps = slalom(speed=0.0, turn=0.0)
    rng = np.random.default_rng(1)
    motion = np.column_stack([0.004 * rng.standard_normal(len(steps)), np.zeros((len(steps), 2))])
    motion[len(steps) // 2, 0] = 1.2
    assert not gross(judge(odometry, replace(steps, motion=motion)))
