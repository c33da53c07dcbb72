"""What the car measures about itself: odometry, IMU and wheel angle as they come, as one state."""

from __future__ import annotations

import math
from typing import Any

from firstlap.ros.node_parameters import value_of

SERVO_RATE = 3.2
ABSURD_SPEED = 50.0
"""[m/s] no such car is faster."""


class StateSource:
    """The newest of every source. Every `*_reason` says why a message must not be used; empty when it may."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self.speed = self.yaw_rate = 0.0
        self.steering: float | None = None
        self._imu = bool(value_of(node, "imu_topic"))

    def reset(self) -> None:
        """Forgets what a filter would remember."""

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

    def imu_reason(self, message: Any) -> str:
        """Of a sensor_msgs/Imu."""
        return "" if math.isfinite(message.angular_velocity.z) else "it is not finite"

    def hear_imu(self, time: float, message: Any) -> None:
        """A good IMU message."""
        self.yaw_rate = message.angular_velocity.z

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

    def hear_command(self, speed: float, steering_angle: float) -> None:
        """What was commanded."""

    def at(self, time: float, commanded: float) -> tuple[float, float, float]:
        """Speed [m/s], yaw rate [rad/s], wheel angle [rad]; without a measured angle, the one last commanded."""
        return self.speed, self.yaw_rate, commanded if self.steering is None else self.steering
