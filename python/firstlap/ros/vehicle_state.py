"""What the car measures about itself: odometry, IMU and wheel angle as they come, as one state."""

from __future__ import annotations

import math
from typing import Any

from firstlap import _core
from firstlap.config.parameters import FieldTable
from firstlap.ros.node_parameters import value_of

ESTIMATE_FIELDS = FieldTable(_core.StateEstimateParams.fields())
ABSURD_SPEED = 50.0
"""[m/s] no such car is faster."""


class StateSource:
    """The newest of every source, or with `fuse_state` what the core's estimate makes of them.

    commanded: [rad] the steering angle that was commanded last.

    Every `*_reason` says why a message must not be used; empty when it may.
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
        """A new estimate with the parameters as they are."""
        if value_of(self._node, "fuse_state"):
            params = _core.StateEstimateParams()
            for field in ESTIMATE_FIELDS.fields:
                params.set(field.section, field.name, value_of(self._node, field.key))
            self._estimate = _core.StateEstimate(params)

    def _predict(self, time: float) -> None:
        """To the time of a measurement; one that is older than the last counts as now."""
        if self._estimate:
            if self._time is not None and time > self._time:
                self._estimate.predict(self.commanded, time - self._time)
            self._time = max(time, self._time or time)

    def odometry_reason(self, twist: Any) -> str:
        """Of a geometry_msgs/Twist in the car's frame."""
        speed, yaw_rate = twist.linear.x, twist.angular.z
        if not (math.isfinite(speed) and math.isfinite(yaw_rate)):
            return "it is not finite"
        return f"{speed:.0f} m/s" if abs(speed) > ABSURD_SPEED else ""

    def hear_odometry(self, time: float, twist: Any) -> None:
        """Good odometry."""
        self.speed = twist.linear.x
        if not self._imu:
            self.yaw_rate = twist.angular.z
        if self._estimate:
            self._predict(time)
            self._estimate.measure_speed(self.speed)
            if not self._imu:
                self._estimate.measure_yaw_rate(self.yaw_rate)

    def imu_reason(self, message: Any) -> str:
        """Of a sensor_msgs/Imu."""
        return "" if math.isfinite(message.angular_velocity.z) else "it is not finite"

    def hear_imu(self, time: float, message: Any) -> None:
        """A good IMU message."""
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
        """Of a sensor_msgs/JointState."""
        angle = self._joint(message)
        if angle is None:
            return f"no joint {value_of(self._node, 'steering_joint')} in it"
        return "" if math.isfinite(angle) else "it is not finite"

    def hear_steering(self, message: Any) -> None:
        """A good wheel angle."""
        self.steering = self._joint(message)
        if self._estimate and self.steering is not None:
            self._estimate.measure_steering(self.steering)

    def hear_command(self, steering_angle: float) -> None:
        """What the servo was told."""
        self.commanded = steering_angle

    def now(self) -> tuple[float, float, float]:
        """Speed [m/s], yaw rate [rad/s], wheel angle [rad]; without a measured angle, the one last commanded."""
        if self._estimate:
            speed, yaw_rate, steering_angle = self._estimate.state()
            return speed, yaw_rate, steering_angle
        return self.speed, self.yaw_rate, self.commanded if self.steering is None else self.steering
