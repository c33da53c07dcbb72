"""The car as the controller predicts it: a single track with nonlinear tyres, at the centre of gravity.

Rajamani, Vehicle Dynamics and Control, 2nd ed., ch. 2 and 13, with load transfer and a friction ellipse per axle;
without slip at walking pace. The same lines serve one state (floats) and a whole horizon (arrays).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from firstlap.car_file import Car
from firstlap.raceline.params import GRAVITY

SETTLE = 0.02
"""[s] in which slip dies out at walking pace."""
GYM_SERVO = 0.02
"""[s] as which f1tenth_gym's rate-limited steering is taken."""
GYM_BUFFER = 0.02
"""[s] that f1tenth_gym keeps a steering command."""

SCALARS = SimpleNamespace(
    sin=math.sin, cos=math.cos, atan=math.atan, sqrt=math.sqrt, hypot=math.hypot, high=max, low=min
)
ARRAYS = SimpleNamespace(
    sin=np.sin, cos=np.cos, atan=np.arctan, sqrt=np.sqrt, hypot=np.hypot, high=np.maximum, low=np.minimum
)


@dataclass(frozen=True)
class Tyre:
    """Magic formula of an axle; `linear` > 0 is a stiffness [1/rad] instead."""

    b: float
    c: float
    d: float
    e: float
    linear: float


@dataclass(frozen=True)
class Model:
    """Constants of one car, SI. gain_up, gain_down [1/s]: acceleration per speed error of the speed loop."""

    mass: float
    inertia: float
    l_f: float
    l_r: float
    height: float
    mu: float
    front: Tyre
    rear: Tyre
    split: float
    drive_grip: float
    servo: float
    steering_limit: float
    steering_rate: float
    steering_delay: float
    speed_delay: float
    gain_up: float
    gain_down: float
    accel: float
    brake: float
    kinematic_below: float

    @property
    def wheelbase(self) -> float:
        """[m]"""
        return self.l_f + self.l_r

    @property
    def grip(self) -> float:
        """Largest acceleration [m/s^2] that the weaker axle's tyres give in any direction."""
        return self.mu * min(self.front.d, self.rear.d) * GRAVITY


def model_of(car: Car, mu: float = 0.0) -> Model:
    """The model of a simulated car; mu 0 takes the car's friction."""
    values = car.core.values()
    v, body = values["vehicle"], values["geometry"]
    gym = v["model"] == 1
    stiffness = (v["gym_stiffness_front"], v["gym_stiffness_rear"]) if gym else (0.0, 0.0)
    front, rear = (
        Tyre(v[f"{axle}_b"], v[f"{axle}_c"], 1.0 if gym else v[f"{axle}_d"], v[f"{axle}_e"], linear)
        for axle, linear in zip(("front", "rear"), stiffness, strict=True)
    )
    up = 10.0 * v["accel_max"] / v["speed_max"] if gym else v["speed_gain"]
    down = 10.0 * v["accel_max"] / max(v["reverse_speed_max"], 0.1) if gym else v["speed_gain"]
    return Model(
        mass=v["mass"],
        inertia=v["yaw_inertia"],
        l_f=v["l_f"],
        l_r=v["l_r"],
        height=v["cg_height"],
        mu=mu or v["friction"],
        front=front,
        rear=rear,
        split=v["drive_split"],
        drive_grip=v["drive_grip"],
        servo=GYM_SERVO if gym else v["servo_time_constant"],
        steering_limit=body["steering_limit"],
        steering_rate=body["steering_rate"],
        steering_delay=v["steering_delay"] + (GYM_BUFFER if gym else 0.0),
        speed_delay=v["speed_delay"],
        gain_up=up,
        gain_down=down,
        accel=v["accel_max"],
        brake=v["accel_max"] if gym else v["brake_max"],
        kinematic_below=v["kinematic_below"],
    )


def loop_acceleration(model: Model, speed: float, command: float) -> float:
    """What the car's speed loop makes of a speed command [m/s^2]."""
    gain = model.gain_up if command > speed else model.gain_down
    most = model.drive_grip * model.mu * GRAVITY
    return max(-min(model.brake, most), min(min(model.accel, most), gain * (command - speed)))


def _lateral(model: Model, tyre: Tyre, slip: Any, load: Any, along: Any, m: Any) -> Any:
    """Lateral force [N] of an axle that also carries `along` [N]."""
    limit = model.mu * tyre.d * load
    used = along / limit
    left = m.sqrt(m.high(0.0, 1.0 - m.low(used * used, model.drive_grip**2)))
    if tyre.linear > 0.0:
        return model.mu * load * tyre.linear * slip
    x = tyre.b * slip
    if tyre.e != 0.0:
        x = x - tyre.e * (x - m.atan(x))
    return limit * m.sin(tyre.c * m.atan(x)) * left


def motion(model: Model, vx: Any, vy: Any, rate: Any, wheel: Any, command: Any, accel: Any, m: Any) -> Any:
    """Derivatives of (vx, vy, yaw rate, wheel angle) for a steering command [rad] and an acceleration [m/s^2]."""
    wheelbase = model.wheelbase
    most = model.steering_rate
    turning = m.high(-most, m.low(most, (command - wheel) / model.servo))
    speed = m.hypot(vx, vy)
    low = model.kinematic_below
    t = m.high(0.0, m.low(1.0, (speed - low) / (0.5 * low)))
    slip_share = t * t * (3.0 - 2.0 * t)
    forward = m.high(vx, 0.7 * low)
    c, s = m.cos(wheel), m.sin(wheel)
    front_load = model.mass * (GRAVITY * model.l_r - accel * model.height) / wheelbase
    rear_load = model.mass * (GRAVITY * model.l_f + accel * model.height) / wheelbase
    force = model.mass * accel
    front_slip = wheel - m.atan((vy + model.l_f * rate) / forward)
    rear_slip = -m.atan((vy - model.l_r * rate) / forward)
    front = _lateral(model, model.front, front_slip, front_load, model.split * force, m)
    rear = _lateral(model, model.rear, rear_slip, rear_load, (1.0 - model.split) * force, m)
    front_y = front * c + model.split * force * s
    ax = accel - slip_share * (front * s / model.mass - vy * rate)
    tangent = s / c
    wanted = vx * tangent / wheelbase
    swing = (accel * tangent + vx * turning * (1.0 + tangent * tangent)) / wheelbase
    free = 1.0 - slip_share
    ay = slip_share * ((front_y + rear) / model.mass - vx * rate) + free * (
        model.l_r * swing + (model.l_r * wanted - vy) / SETTLE
    )
    spin = slip_share * (model.l_f * front_y - model.l_r * rear) / model.inertia + free * (
        swing + (wanted - rate) / SETTLE
    )
    return ax, ay, spin, turning


def rear_slip_angle(model: Model, vx: Any, vy: Any, rate: Any) -> Any:
    """Angle [rad] between the motion of base_link and the car's heading, left positive (small angles)."""
    return (vy - model.l_r * rate) / vx
