"""The measured vehicle state from odometry, IMU and steering angle."""

from __future__ import annotations

import math
from typing import Any

from firstlap import _core
from firstlap.config.parameters import FieldTable
from firstlap.ros.node_parameters import value_of

ESTIMATE_FIELDS = FieldTable(_core.StateEstimateParams.fields())
MAX_PLAUSIBLE_SPEED = 50.0
"""[m/s] Higher measured speeds are invalid."""


class StateSource:
    """The newest values of all sources, or with `fuse_state` the core's fused estimate.

    commanded: last commanded steering angle [rad].

    Each `*_reason` returns why a message must not be used; empty if it may.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self.speed = self.yaw_rate = 0.0
        self.steering: float | None = None
        self._imu = bool(value_of(node, "imu_topic"))
        self.commanded = 0.0
        self._time: float | None = None
        self._estimate: _core.StateEstimate | None = None
        self.set_estimate()

    def set_estimate(self) -> None:
        """Creates the estimate with the current parameters."""
        if value_of(self._node, "fuse_state"):
            params = _core.StateEstimateParams()
            for field in ESTIMATE_FIELDS.fields:
                params.set(field.section, field.name, value_of(self._node, field.key))
            self._estimate = _core.StateEstimate(params)

    def _predict(self, time: float) -> None:
        """Predicts to the time of a measurement; an older one than the last counts as simultaneous."""
        if self._estimate:
            if self._time is not None and time > self._time:
                self._estimate.predict(self.commanded, time - self._time)
            self._time = max(time, self._time or time)

    def odometry_reason(self, twist: Any) -> str:
        """Checks a geometry_msgs/Twist in the car's frame."""
        speed, yaw_rate = twist.linear.x, twist.angular.z
        if not (math.isfinite(speed) and math.isfinite(yaw_rate)):
            return "not finite"
        return f"implausible speed of {speed:.0f} m/s" if abs(speed) > MAX_PLAUSIBLE_SPEED else ""

    def add_odometry(self, time: float, twist: Any) -> None:
        """Adds valid odometry."""
        self.speed = twist.linear.x
        if not self._imu:
            self.yaw_rate = twist.angular.z
        if self._estimate:
            self._predict(time)
            self._estimate.measure_speed(self.speed)
            if not self._imu:
                self._estimate.measure_yaw_rate(self.yaw_rate)

    def imu_reason(self, message: Any) -> str:
        """Checks a sensor_msgs/Imu."""
        return "" if math.isfinite(message.angular_velocity.z) else "not finite"

    def add_imu(self, time: float, message: Any) -> None:
        """Adds a valid IMU message."""
        self.yaw_rate = message.angular_velocity.z
        if self._estimate:
            self._predict(time)
            self._estimate.measure_yaw_rate(self.yaw_rate)

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

    def add_steering(self, message: Any) -> None:
        """Adds a valid steering angle."""
        self.steering = self._joint(message)
        if self._estimate and self.steering is not None:
            self._estimate.measure_steering(self.steering)

    def add_command(self, steering_angle: float) -> None:
        """Adds a commanded steering angle [rad]."""
        self.commanded = steering_angle

    def now(self) -> tuple[float, float, float]:
        """Speed [m/s], yaw rate [rad/s] and steering angle [rad]; without a measured angle, the last commanded one."""
        if self._estimate:
            speed, yaw_rate, steering_angle = self._estimate.state()
            return speed, yaw_rate, steering_angle
        return self.speed, self.yaw_rate, self.commanded if self.steering is None else self.steering
