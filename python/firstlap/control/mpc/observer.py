"""The observer: predicts the car's state with the model and corrects it with measurements."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from firstlap.control.mpc.model import CREEP, SCALARS, Model, loop_acceleration, motion
from firstlap.control.mpc.params import MpcParams

STEP = 0.0125
"""[s] Maximum integration step."""

Body = tuple[float, float, float, float, float, float, float]
"""x, y, yaw of base_link (map frame), vx, vy at the center of gravity, yaw rate, steering angle."""


def wrapped(angle: float) -> float:
    """Wraps an angle to -pi to pi."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


class Commands:
    """Past commands and the times at which they act."""

    def __init__(self) -> None:
        self._steering: deque[tuple[float, float]] = deque([(-math.inf, 0.0)], maxlen=64)
        self._speed: deque[tuple[float, float]] = deque([(-math.inf, 0.0)], maxlen=64)

    def give_steering(self, time: float, angle: float) -> None:
        """Adds a command that acts from `time` [s] on."""
        self._steering.append((time, angle))

    def give_speed(self, time: float, speed: float) -> None:
        """Adds a command that acts from `time` [s] on."""
        self._speed.append((time, speed))

    def steering(self, time: float) -> float:
        """Steering command in effect at a time [rad]."""
        return _at(self._steering, time)

    def speed(self, time: float) -> float:
        """Speed command in effect at a time [m/s]."""
        return _at(self._speed, time)


def _at(queue: deque[tuple[float, float]], time: float) -> float:
    for begin, value in reversed(queue):
        if begin <= time + 1e-9:
            return value
    return queue[0][1]


def predicted(model: Model, body: Body, commands: Commands, begin: float, end: float) -> Body:
    """The state at `end` [s], from `begin`, with the given commands; second-order integration."""
    count = max(1, math.ceil((end - begin) / STEP - 1e-9))
    h = (end - begin) / count
    for i in range(count if h > 0.0 else 0):
        middle = begin + (i + 0.5) * h
        steering, speed = commands.steering(middle), commands.speed(middle)
        half = _moved(body, _rate(model, body, steering, speed), 0.5 * h)
        body = _moved(body, _rate(model, half, steering, speed), h)
    return body


def _rate(model: Model, body: Body, steering: float, speed: float) -> Body:
    _, _, yaw, vx, vy, rate, wheel = body
    accel = loop_acceleration(model, vx, speed)
    most = model.steering_rate
    turning = max(-most, min(most, (steering - wheel) / model.servo))
    ax, ay, spin = motion(model, vx, vy, rate, wheel, accel, SCALARS)
    across = vy - model.l_r * rate
    c, s = math.cos(yaw), math.sin(yaw)
    return vx * c - across * s, vx * s + across * c, rate, ax, ay, spin, turning


def _moved(body: Body, rate: Body, h: float) -> Body:
    x, y, yaw, vx, vy, turn, wheel = (value + h * slope for value, slope in zip(body, rate, strict=True))
    return x, y, yaw, max(vx, 0.0), vy, turn, wheel


def corrected(
    model: Model,
    body: Body,
    pose: tuple[float, float, float] | None,
    pose_age: float,
    measured: tuple[float, float, float] | None,
    params: MpcParams,
) -> Body:
    """The state corrected toward a pose of `pose_age` [s] ago and measured speed, yaw rate, steering angle."""
    x, y, yaw, vx, vy, rate, wheel = body
    if measured is not None:
        gain = params.state_gain
        vx += gain * (measured[0] - vx)
        rate += gain * (measured[1] - rate)
        wheel += gain * (measured[2] - wheel)
    if pose is not None:
        gain = params.place_gain
        across = vy - model.l_r * rate
        heading = pose[2] + pose_age * rate
        middle = pose[2] + 0.5 * pose_age * rate
        c, s = math.cos(middle), math.sin(middle)
        dx = pose[0] + pose_age * (vx * c - across * s) - x
        dy = pose[1] + pose_age * (vx * s + across * c) - y
        x, y = x + gain * dx, y + gain * dy
        yaw = wrapped(yaw + params.heading_gain * wrapped(heading - yaw))
        # The lateral speed is not measured; it is corrected by the lateral error of the pose.
        if vx > CREEP:
            vy += params.drift_gain * (dy * c - dx * s)
    return x, y, yaw, max(vx, 0.0), vy, rate, wheel


def standing(pose: tuple[float, float, float], measured: tuple[float, float, float], model: Model) -> Body:
    """The state from one measurement, without slip."""
    speed, rate, wheel = measured
    return pose[0], pose[1], pose[2], max(speed, 0.0), model.l_r * rate, rate, wheel


def finite(values: object, largest: float = 1e6) -> bool:
    """Whether all numbers are finite and plausible."""
    found = np.asarray(values, dtype=np.float64)
    return bool(np.isfinite(found).all() and (np.abs(found) < largest).all())
