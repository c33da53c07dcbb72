"""The driving node's vehicle state from odometry, IMU and steering angle, without ROS."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from firstlap.common.imu import NOT_MEASURED
from firstlap.drivers.driving import Driving
from firstlap.ros.vehicle_state import ESTIMATE_FIELDS, StateSource


class Node:
    """Parameters only."""

    def __init__(self, **values: Any) -> None:
        defaults = {field.key: field.default for field in ESTIMATE_FIELDS.fields}
        self.values = {**defaults, "imu_topic": "imu", "steering_joint": "steering", **values}

    def get_parameter(self, name: str) -> Any:
        return SimpleNamespace(value=self.values[name])


def twist(speed: float, yaw_rate: float = 0.0) -> Any:
    return SimpleNamespace(linear=SimpleNamespace(x=speed), angular=SimpleNamespace(z=yaw_rate))


def imu(yaw_rate: float, forward: float = 0.0, covariance: float = 0.0, up: float = 9.81, turning: float = 0.0) -> Any:
    """covariance, turning: covariances of the acceleration and of the yaw rate."""
    return SimpleNamespace(
        angular_velocity=SimpleNamespace(z=yaw_rate),
        angular_velocity_covariance=[turning] * 9,
        linear_acceleration=SimpleNamespace(x=forward, y=0.0, z=up),
        linear_acceleration_covariance=[covariance] * 9,
    )


def source(enabled: bool, **values: Any) -> StateSource:
    return StateSource(Node(**{"state_estimate.enabled": enabled, **values}), Driving.of("local", "sure"))


def roll(state: StateSource, speed: float, seconds: float, forward: float = 0.0, covariance: float = 0.0,
         begin: float = 0.0) -> float:  # fmt: skip
    """Drives straight ahead at a wheel speed of `speed`. Returns the time at the end."""
    state.add_command(speed, 0.0)
    for i in range(1, round(seconds / 0.02) + 1):
        now = begin + 0.02 * i
        state.add_imu(now, imu(0.05, forward, covariance))
        state.add_odometry(now, twist(speed))
        state.add_steering(now, SimpleNamespace(name=["steering"], position=[0.0]))
    return now


def test_without_the_estimate_the_state_is_the_newest_value_of_each_source():
    state = source(False)
    roll(state, 2.0, 0.1)
    assert state.now() == (2.0, 0.05, 0.0)


def test_the_estimate_finds_the_gyro_bias():
    state = source(True)
    roll(state, 2.0, 10.0)
    speed, yaw_rate, steering_angle = state.now()
    assert speed == pytest.approx(2.0, abs=0.02)
    assert yaw_rate == pytest.approx(0.0, abs=0.02)
    assert steering_angle == pytest.approx(0.0, abs=1e-6)


def test_locked_wheels_are_rejected_if_there_is_an_accelerometer():
    state = source(True)
    end = roll(state, 4.0, 2.0)
    roll(state, 0.0, 0.4, forward=-5.0, begin=end)
    assert state.speed == 0.0
    assert state.now()[0] == pytest.approx(2.0, abs=0.1)


def test_the_acceleration_of_an_imu_without_an_accelerometer_is_ignored():
    state = source(True)
    roll(state, 2.0, 2.0, forward=9.0, covariance=NOT_MEASURED)
    assert state.now()[0] == pytest.approx(2.0, abs=0.05)


def test_the_estimate_uses_the_car_of_the_setup():
    state = source(True)
    driving = Driving.of("local", "sure")
    driving.change({"car.servo_time_constant": 0.5, "car.steering_delay": 0.0})
    slow = StateSource(Node(**{"state_estimate.enabled": True}), driving)
    for one in (state, slow):
        one.add_command(1.0, 0.2)
        for i in range(10):
            one.add_odometry(0.02 * i, twist(1.0))
    assert slow.now()[2] < 0.5 * state.now()[2]
    assert math.isfinite(slow.now()[0])


def test_a_car_that_the_node_does_not_drive_is_not_expected_to_follow_its_last_command():
    state = source(True)
    state.add_command(0.0, 0.0)
    state.release()
    for i in range(1, 501):
        state.add_imu(0.02 * i, imu(1.5, covariance=NOT_MEASURED))
        state.add_odometry(0.02 * i, twist(2.0))
    speed, yaw_rate, _ = state.now()
    assert speed == pytest.approx(2.0, abs=0.05)
    assert yaw_rate == pytest.approx(1.5, abs=0.05)


def test_changed_parameters_keep_the_estimate_and_switching_it_off_and_on_forgets_it():
    state = source(True)
    roll(state, 2.0, 2.0)
    state._node.values["state_estimate.gate"] = 5.0
    state.set_estimate()
    assert state.now()[0] == pytest.approx(2.0, abs=0.02)
    for enabled in (False, True):
        state._node.values["state_estimate.enabled"] = enabled
        state.set_estimate()
    assert state.now()[0] == 0.0


def test_without_an_imu_the_yaw_rate_of_the_odometry_is_no_gyro():
    state = source(True, imu_topic="")
    state.add_command(2.0, 0.0)
    for i in range(1, 101):
        state.add_odometry(0.02 * i, twist(2.0, 1.0))
    assert state.now()[1] == pytest.approx(0.0, abs=0.02)
    assert source(False, imu_topic="").now()[1] == 0.0


def test_an_acceleration_in_g_is_refused_at_standstill():
    state = source(True)
    state.add_odometry(0.0, twist(0.0))
    assert "in g?" in state.imu_reason(imu(0.0, up=1.0))
    assert state.imu_reason(imu(0.0, up=9.81)) == state.imu_reason(imu(0.0, up=0.0)) == ""
    state.add_odometry(0.1, twist(2.0))
    assert state.imu_reason(imu(0.0, forward=1.0, up=0.0)) == ""
    assert "not finite" in state.imu_reason(imu(math.nan))


def test_an_imu_without_a_gyro_is_not_used():
    """Its yaw rate of 0 would say that the car drives straight on."""
    assert "no gyro" in source(False).imu_reason(imu(0.0, turning=NOT_MEASURED))
