"""The controller's model of the car: single track with nonlinear tires, at the center of gravity.

Rajamani, Vehicle Dynamics and Control, 2nd ed., ch. 2 and 13, with load transfer and a friction ellipse per axle.
The functions work for one state (floats) and a whole horizon (arrays).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from firstlap.config.car_file import Car
from firstlap.planning.raceline.params import GRAVITY, Grip, grip_of

CREEP = 1.0
"""[m/s] Speed below which slip angles are softened."""
GYM_SERVO = 0.02
"""[s] Time constant that represents f1tenth_gym's rate-limited steering."""
GYM_BUFFER = 0.02
"""[s] Delay of f1tenth_gym's steering command."""

SCALARS = SimpleNamespace(
    sin=math.sin, cos=math.cos, atan=math.atan, sqrt=math.sqrt, hypot=math.hypot, high=max, low=min
)
ARRAYS = SimpleNamespace(
    sin=np.sin, cos=np.cos, atan=np.arctan, sqrt=np.sqrt, hypot=np.hypot, high=np.maximum, low=np.minimum
)


@dataclass(frozen=True)
class Tire:
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
    front: Tire
    rear: Tire
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
    grip: Grip

    @property
    def wheelbase(self) -> float:
        """Wheelbase [m]."""
        return self.l_f + self.l_r

    @property
    def most_accel(self) -> float:
        """Largest acceleration [m/s^2] of motor and tires on a straight."""
        return min(self.accel, self.drive_grip * self.grip.drive)

    @property
    def most_brake(self) -> float:
        """Largest deceleration [m/s^2] of brake and tires on a straight."""
        return min(self.brake, self.drive_grip * self.grip.brake)

    @property
    def servo_reach(self) -> float:
        """Difference [rad] of command and steering angle at which the servo reaches its maximum rate."""
        return self.steering_rate * self.servo


def model_of(car: Car, mu: float = 0.0) -> Model:
    """The model of a simulated car; mu 0 takes the car's friction."""
    values = car.core.values()
    v, body = values["vehicle"], values["geometry"]
    gym = v["model"] == 1
    stiffness = (v["gym_stiffness_front"], v["gym_stiffness_rear"]) if gym else (0.0, 0.0)
    front, rear = (
        Tire(v[f"{axle}_b"], v[f"{axle}_c"], 1.0 if gym else v[f"{axle}_d"], v[f"{axle}_e"], linear)
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
        grip=grip_of(car, mu),
    )


def loop_acceleration(model: Model, speed: float, command: float) -> float:
    """Acceleration of the car's speed loop for a speed command [m/s^2]."""
    gain = model.gain_up if command > speed else model.gain_down
    return max(-model.most_brake, min(model.most_accel, gain * (command - speed)))


def _lateral(model: Model, tire: Tire, slip: Any, load: Any, along: Any, m: Any) -> Any:
    """Lateral force [N] of an axle with longitudinal force `along` [N]."""
    limit = model.mu * tire.d * load
    used = along / limit
    left = m.sqrt(m.high(0.0, 1.0 - m.low(used * used, model.drive_grip**2)))
    if tire.linear > 0.0:
        return model.mu * load * tire.linear * slip
    x = tire.b * slip
    if tire.e != 0.0:
        x = x - tire.e * (x - m.atan(x))
    return limit * m.sin(tire.c * m.atan(x)) * left


def motion(model: Model, vx: Any, vy: Any, rate: Any, wheel: Any, accel: Any, m: Any) -> Any:
    """Derivatives of (vx, vy, yaw rate) at a steering angle [rad] and a longitudinal acceleration [m/s^2].

    A slip angle is the lateral velocity of the wheel over the speed, which is limited to at least about CREEP: at
    walking pace the car then turns with the speed over the radius, without slip, and nothing is stiff.
    """
    wheelbase = model.l_f + model.l_r
    square = vx * vx
    speed = m.sqrt(m.sqrt(square * square + CREEP**4))
    c, s = m.cos(wheel), m.sin(wheel)
    front_load = model.mass * (GRAVITY * model.l_r - accel * model.height) / wheelbase
    rear_load = model.mass * (GRAVITY * model.l_f + accel * model.height) / wheelbase
    force = model.mass * accel
    front_slip = m.atan((vx * s - (vy + model.l_f * rate) * c) / speed)
    rear_slip = m.atan((model.l_r * rate - vy) / speed)
    front = _lateral(model, model.front, front_slip, front_load, model.split * force, m)
    rear = _lateral(model, model.rear, rear_slip, rear_load, (1.0 - model.split) * force, m)
    front_y = front * c + model.split * force * s
    ax = accel - front * s / model.mass + vy * rate
    ay = (front_y + rear) / model.mass - vx * rate
    return ax, ay, (model.l_f * front_y - model.l_r * rear) / model.inertia
