"""The simulated sensor errors with which the state estimate is evaluated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Case:
    """options: conditions as for `firstlap race --option`."""

    name: str
    description: str
    options: Mapping[str, float] = field(default_factory=dict)


BIASES = {
    "sensors.yaw_rate_bias": 0.052,
    "sensors.acceleration_x_bias": 0.39,
    "sensors.acceleration_y_bias": 0.39,
}
"""Largest typical offsets of the Bosch BMI160's data sheet: 3 degrees per second and 40 mg."""
SLIP = {"sensors.wheel_slip": 0.03}
LOCK = {"sensors.wheel_lock_deceleration": 2.5}

CASES = (
    Case("clean", "the default sensors"),
    Case("bias", "gyro and accelerometer with the largest bias of the data sheet", BIASES),
    Case("slip", "wheels slip by 3 % per m/s²", SLIP),
    Case("lock", "wheels lock above 2.5 m/s² of braking", LOCK),
    Case("all", "all of these errors", BIASES | SLIP | LOCK),
)
