"""What the line and its speeds may ask of the car: the only place where their defaults stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firstlap.car_file import Car
from firstlap.table import row, table_of

GRAVITY = 9.81


@dataclass(frozen=True)
class LineParams:
    """How a racing line is computed. See docs/parameters.md."""

    mu: float = row(0.0, "", 0.0, 3.0, "friction to plan with; 0 takes the car's")
    grip_use: float = row(0.85, "", 0.1, 1.0, "share of the tyres' grip that the line may use")
    margin: float = row(0.10, "m", 0.0, 0.5, "room kept between the car's rectangle and any wall")
    speed_max: float = row(0.0, "m/s", 0.0, 100.0, "highest speed; 0 takes the car's")
    accel_max: float = row(0.0, "m/s^2", 0.0, 50.0, "largest acceleration; 0 takes the motor's limit")
    brake_max: float = row(0.0, "m/s^2", 0.0, 50.0, "largest deceleration; 0 takes the brake's limit")
    steering_use: float = row(0.9, "", 0.3, 1.0, "share of the steering range that the sharpest bend may need")
    spacing: float = row(0.1, "m", 0.03, 0.5, "between points of the line")
    smoothness: float = row(
        3e-4, "s m^2", 0.0, 1.0, "time that the optimiser pays for a curvature change, per (dk/ds)^2"
    )
    curvature_rounds: int = row(25, "", 1, 200, "largest number of minimum-curvature steps")
    time_rounds: int = row(60, "", 0, 500, "largest number of minimum-time steps; 0 leaves the minimum-curvature line")


LINE_FIELDS = table_of(line=LineParams)


@dataclass(frozen=True)
class Limits:
    """What the profile obeys: the ellipse (a_x / grip_x)^2 + (a_y / grip_y)^2 <= 1, and the motor's own limits.

    grip_x, grip_y, accel, brake [m/s^2], speed [m/s], curvature [1/m].
    """

    grip_x: float
    grip_y: float
    accel: float
    brake: float
    speed: float
    curvature: float


def limits_of(car: Car, params: LineParams) -> Limits:
    """The limits of a car under these parameters.

    Grip is that of the weaker axle's tyres at their peak; driving and braking get the share of it that the car's
    drive can use.
    """
    values = car.core.values()
    vehicle, body = values["vehicle"], values["geometry"]
    peak = min(vehicle["front_d"], vehicle["rear_d"]) if vehicle["model"] == 0 else 1.0
    grip = (params.mu or vehicle["friction"]) * peak * GRAVITY * params.grip_use
    return Limits(
        grip_x=grip,
        grip_y=grip,
        accel=min(params.accel_max or vehicle["accel_max"], vehicle["drive_grip"] * grip),
        brake=min(params.brake_max or vehicle["brake_max"], vehicle["drive_grip"] * grip),
        speed=params.speed_max or vehicle["speed_max"],
        curvature=math.tan(params.steering_use * body["steering_limit"]) / body["wheelbase"],
    )
