"""The measured vehicle state from odometry, IMU and steering angle."""

from __future__ import annotations

import math
from typing import Any

from firstlap import _core
from firstlap.common.imu import measures
from firstlap.config.car_file import car_section
from firstlap.config.parameters import FieldTable
from firstlap.drivers.driving import Driving
from firstlap.ros.node_parameters import value_of

ESTIMATE_FIELDS = FieldTable(_core.StateEstimateParams.fields())
MAX_PLAUSIBLE_SPEED = 50.0
"""[m/s] Higher measured speeds are invalid."""
STANDSTILL = 0.05
"""[m/s] Below this wheel speed the car stands still."""
ONE_G = (0.8, 1.2)
"""Range of the norm of an acceleration in g at standstill; in m/s^2 it is 9.8, or 0 without gravity (REP 145)."""
UNKNOWN = (math.nan, math.nan)
"""Command while the node does not drive: a person or another program may."""


def reading(
    wheel_speed: float = math.nan,
    yaw_rate: float = math.nan,
    steering_angle: float = math.nan,
    acceleration: tuple[float, float] = (math.nan, math.nan),
) -> _core.SensorReading:
    """The measurements of one message; NaN: not measured."""
    return _core.SensorReading(wheel_speed, yaw_rate, steering_angle, *acceleration)


class StateSource:
    """The newest values of all sources, or with `state_estimate.enabled` the core's state estimate.

    commanded: last speed [m/s] and steering angle [rad] that the node commanded.

    Each `*_reason` returns why a message must not be used; empty if it may.
    """

    def __init__(self, node: Any, driving: Driving) -> None:
        self._node, self._driving = node, driving
        self.speed = self.yaw_rate = 0.0
        self._odometry = False
        self.steering: float | None = None
        self._imu = bool(value_of(node, "imu_topic"))
        self.commanded = (0.0, 0.0)
        self._in_effect = UNKNOWN
        self._time: float | None = None
        self._estimate: _core.StateEstimate | None = None
        self.set_estimate()

    def set_estimate(self) -> None:
        """Gives the estimate the current parameters, creates it if it is switched on, or drops it if it is off."""
        params = _core.StateEstimateParams()
        for field in ESTIMATE_FIELDS.fields:
            params.set(field.section, field.name, value_of(self._node, field.key))
        enabled = value_of(self._node, "state_estimate.enabled")
        if not enabled:
            self._estimate = None
        elif self._estimate:
            self._estimate.set_params(params, self._car())
        else:
            self._estimate = _core.StateEstimate(params, self._car())

    def _standing(self) -> bool:
        """Whether the odometry says that the car stands still."""
        return self._odometry and abs(self.speed) < STANDSTILL

    def _car(self) -> _core.Car:
        """The car as configured for its driver."""
        core = _core.Car()
        for field in self._driving.fields:
            if field.section == "car":
                core.set(car_section(field.name), field.name, self._driving.setup.get(field.key))
        return core

    def _update(self, time: float, measured: _core.SensorReading) -> None:
        """Updates at the time of a measurement; an older one than the last counts as simultaneous."""
        if self._estimate:
            step = 0.0 if self._time is None else max(time - self._time, 0.0)
            self._time = max(time, self._time or time)
            self._estimate.update(measured, *self._in_effect, step)

    def odometry_reason(self, twist: Any) -> str:
        """Checks a geometry_msgs/Twist in the car's frame."""
        speed, yaw_rate = twist.linear.x, twist.angular.z
        if not (math.isfinite(speed) and math.isfinite(yaw_rate)):
            return "not finite"
        return f"implausible speed of {speed:.0f} m/s" if abs(speed) > MAX_PLAUSIBLE_SPEED else ""

    def add_odometry(self, time: float, twist: Any) -> None:
        """Adds valid odometry.

        The estimate does not take its yaw rate: nodes of a motor controller calculate it from speed and steering angle.
        """
        self.speed, self._odometry = twist.linear.x, True
        if not self._imu:
            self.yaw_rate = twist.angular.z
        self._update(time, reading(self.speed))

    def imu_reason(self, message: Any) -> str:
        """Checks a sensor_msgs/Imu."""
        if not measures(message.angular_velocity_covariance):
            return "no gyro: its angular_velocity_covariance begins with -1, which means not measured"
        if not math.isfinite(message.angular_velocity.z):
            return "not finite"
        measured = message.linear_acceleration
        norm = math.hypot(measured.x, measured.y, measured.z)
        if self._estimate and self._standing() and ONE_G[0] < norm < ONE_G[1]:
            return f"acceleration of {norm:.2f} at standstill: in g? expected m/s^2, 9.8 or (without gravity) 0"
        return ""

    def add_imu(self, time: float, message: Any) -> None:
        """Adds a valid IMU message."""
        self.yaw_rate = message.angular_velocity.z
        measured = message.linear_acceleration
        if measures(message.linear_acceleration_covariance):
            self._update(time, reading(yaw_rate=self.yaw_rate, acceleration=(measured.x, measured.y)))
        else:
            self._update(time, reading(yaw_rate=self.yaw_rate))

    def _joint(self, message: Any) -> float | None:
        joint = value_of(self._node, "steering_joint")
        for name, position in zip(message.name, message.position, strict=False):
            if name == joint:
                return float(position)
        return None

    def steering_reason(self, message: Any) -> str:
        """Checks a sensor_msgs/JointState."""
        angle = self._joint(message)
        if angle is None:
            return f"no joint {value_of(self._node, 'steering_joint')}"
        return "" if math.isfinite(angle) else "not finite"

    def add_steering(self, time: float, message: Any) -> None:
        """Adds a valid steering angle."""
        self.steering = self._joint(message)
        if self.steering is not None:
            self._update(time, reading(steering_angle=self.steering))

    def add_command(self, speed: float, steering_angle: float) -> None:
        """Adds a commanded speed [m/s] and steering angle [rad]."""
        self.commanded = self._in_effect = (speed, steering_angle)

    def release(self) -> None:
        """The node does not drive: what the car is told is not known."""
        self._in_effect = UNKNOWN

    def now(self) -> tuple[float, float, float]:
        """Speed [m/s], yaw rate [rad/s] and steering angle [rad]; without a measured angle, the last commanded one."""
        if self._estimate:
            found = self._estimate.estimate()
            return found.speed, found.yaw_rate, found.steering_angle
        return self.speed, self.yaw_rate, self.commanded[1] if self.steering is None else self.steering
