"""Parameters of the racing line."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firstlap.config.car_file import Car
from firstlap.config.table import row, table_of

GRAVITY = 9.81


@dataclass(frozen=True)
class LineParams:
    """Parameters of the racing line, see docs/parameters.md."""

    mu: float = row(0.0, "", 0.0, 3.0, "friction used for planning (0: the car's)")
    grip_use: float = row(0.82, "", 0.1, 1.0, "share of the tires' grip that the line may use")
    margin: float = row(0.10, "m", 0.0, 0.5, "minimum clearance between the car's rectangle and the walls")
    speed_max: float = row(0.0, "m/s", 0.0, 100.0, "maximum speed (0: the car's)")
    accel_max: float = row(0.0, "m/s^2", 0.0, 50.0, "maximum acceleration (0: the motor's limit)")
    brake_max: float = row(0.0, "m/s^2", 0.0, 50.0, "maximum deceleration (0: the brake's limit)")
    steering_use: float = row(0.9, "", 0.3, 1.0, "share of the steering range that the line may use")
    spacing: float = row(0.1, "m", 0.03, 0.5, "spacing of the line's points")
    smoothness: float = row(2e-5, "s^6/m^2", 0.0, 1.0, "penalty of squared lateral jerk, as lap time per second")
    curvature_rounds: int = row(25, "", 1, 200, "maximum number of minimum-curvature iterations")
    time_rounds: int = row(60, "", 0, 500, "maximum number of minimum-time iterations (0: minimum-curvature line)")


LINE_FIELDS = table_of(line=LineParams)


@dataclass(frozen=True)
class Grip:
    """Maximum accelerations [m/s^2] by the grip of the tires: lateral, driving, and braking."""

    lateral: float
    drive: float
    brake: float


@dataclass(frozen=True)
class Limits:
    """Limits of the velocity profile: the ellipse (a_x / grip_x)^2 + (a_y / lateral)^2 <= 1, and the motor's own
    limits.

    grip: its axes, grip_x being drive or brake. accel, brake [m/s^2], speed [m/s], curvature [1/m].
    """

    grip: Grip
    accel: float
    brake: float
    speed: float
    curvature: float


def grip_of(car: Car, mu: float) -> Grip:
    """The grip of a car with friction `mu` (0: the car's).

    An axle slides when its share of the longitudinal force reaches the grip of its tires under the axle load at this
    acceleration; the car's longitudinal grip is that of the axle that slides first.
    """
    v = car.core.values()["vehicle"]
    mu = mu or float(v["friction"])
    if v["model"] != 0:
        return Grip(mu * GRAVITY, mu * GRAVITY, mu * GRAVITY)
    wheelbase, height = v["l_f"] + v["l_r"], v["cg_height"]
    front, rear, split = mu * v["front_d"], mu * v["rear_d"], v["drive_split"]

    def sliding(peak: float, arm: float, share: float, gains: float) -> float:
        room = share * wheelbase - gains * peak * height
        return float(peak * GRAVITY * arm / room) if room > 0.0 else math.inf

    most = float(max(front, rear)) * GRAVITY
    return Grip(
        lateral=float(min(front, rear)) * GRAVITY,
        drive=min(most, sliding(front, v["l_r"], split, -1.0), sliding(rear, v["l_f"], 1.0 - split, 1.0)),
        brake=min(most, sliding(front, v["l_r"], split, 1.0), sliding(rear, v["l_f"], 1.0 - split, -1.0)),
    )


def limits_of(car: Car, params: LineParams) -> Limits:
    """The limits of a car under these parameters."""
    values = car.core.values()
    vehicle, body = values["vehicle"], values["geometry"]
    full, use = grip_of(car, params.mu), params.grip_use
    return Limits(
        grip=Grip(full.lateral * use, full.drive * use, full.brake * use),
        accel=min(params.accel_max or vehicle["accel_max"], vehicle["drive_grip"] * full.drive * use),
        brake=min(params.brake_max or vehicle["brake_max"], vehicle["drive_grip"] * full.brake * use),
        speed=params.speed_max or vehicle["speed_max"],
        curvature=math.tan(params.steering_use * body["steering_limit"]) / body["wheelbase"],
    )
