"""Rules of thumb for a setup: neutral lookahead, delay, grip (docs/paper.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup

GRAVITY = 9.81
GRIP_SHARE = 0.8
PHASE_LIMIT = 0.8
NEUTRAL_BAND = 0.15


@dataclass(frozen=True)
class LimitCheck:
    """One rule: its value, its limit, whether it is satisfied, and a remark."""

    name: str
    formula: str
    value: float
    wanted: str
    unit: str
    holds: bool
    remark: str


def check_limits(setup: Setup, car: Car) -> list[LimitCheck]:
    """All rules for a setup on a car."""
    parameters = {
        f"{section}.{name}": float(value)
        for section, values in setup.params(car.core).values().items()
        for name, value in values.items()
    }
    car_values = {section: dict(values) for section, values in car.core.values().items()}
    if setup.driver != "local":
        return _grip(parameters, car_values["vehicle"], "speed") if "speed.a_y_max" in parameters else []
    return [
        *_neutral(parameters),
        _delay(parameters, car_values["vehicle"]),
        *_grip(parameters, car_values["vehicle"], "velocity_profile"),
        _speed_loop(parameters, car_values["vehicle"]),
    ]


def _neutral(p: dict[str, float]) -> list[LimitCheck]:
    """In a steady corner the car is on the line if k_ang (1 + L / wheelbase) = 1."""
    if p["stanley.schedule_omega"] > 0.0:
        return [_scheduled(p)]
    return [_neutral_at(p, curvature) for curvature in (0.0, 1.0)]


def _neutral_at(p: dict[str, float], curvature: float) -> LimitCheck:
    lookahead = p["stanley.l_max"] / (1.0 + curvature / p["stanley.kappa_n"])
    value = p["stanley.k_ang"] * (1.0 + lookahead / p["car.wheelbase"])
    holds = abs(value - 1.0) <= NEUTRAL_BAND
    way = "neutral" if abs(value - 1.0) < 0.03 else "cuts inside" if value > 1.0 else "runs wide"
    wanted_lookahead = p["car.wheelbase"] * (1.0 / max(p["stanley.k_ang"], 0.01) - 1.0)
    where = "at curvature 1/m" if curvature else "nearly straight"
    return LimitCheck(
        f"neutral lookahead, {where}",
        "k_ang (1 + L / wheelbase)",
        value,
        f"1 ± {NEUTRAL_BAND}",
        "",
        holds,
        f"{way}; L is {lookahead:.2f} m, neutral is {wanted_lookahead:.2f} m",
    )


def _scheduled(p: dict[str, float]) -> LimitCheck:
    """With the schedule the lookahead is neutral unless limited by l_max."""
    speed = p["velocity_profile.v_max"]
    k_ang = min(p["stanley.k_ang"], p["stanley.schedule_omega"] * p["car.wheelbase"] / speed)
    wanted = p["car.wheelbase"] * (1.0 / max(k_ang, 0.05) - 1.0)
    value = k_ang * (1.0 + min(wanted, p["stanley.l_max"]) / p["car.wheelbase"])
    return LimitCheck(
        "neutral lookahead, scheduled",
        "k_ang(v_max) (1 + L / wheelbase)",
        value,
        f"1 ± {NEUTRAL_BAND}",
        "",
        abs(value - 1.0) <= NEUTRAL_BAND,
        f"at v_max k_ang is {k_ang:.2f}, neutral is L = {wanted:.2f} m; l_max is {p['stanley.l_max']:.2f} m",
    )


def _delay(p: dict[str, float], vehicle: dict[str, float]) -> LimitCheck:
    """The heading loop crosses over at v k_ang / wheelbase; delay and servo reduce its phase margin."""
    speed = p["velocity_profile.v_max"]
    k_ang = p["stanley.k_ang"]
    if p["stanley.schedule_omega"] > 0.0:
        k_ang = min(k_ang, p["stanley.schedule_omega"] * p["car.wheelbase"] / speed)
    delay = vehicle["steering_delay"] + vehicle["servo_time_constant"]
    value = speed * k_ang / p["car.wheelbase"] * delay
    limit = PHASE_LIMIT * p["car.wheelbase"] / max(k_ang * delay, 1e-9)
    return LimitCheck(
        "delay",
        "v_max k_ang / wheelbase · T",
        value,
        f"< {PHASE_LIMIT}",
        "",
        value < PHASE_LIMIT,
        f"T = {delay:.3f} s of delay and servo; satisfied up to {limit:.1f} m/s",
    )


def _grip(p: dict[str, float], vehicle: dict[str, float], section: str) -> list[LimitCheck]:
    """The lateral acceleration of the speeds in `section` must be within the grip of the tires."""
    friction = vehicle["friction"] * min(vehicle["front_d"], vehicle["rear_d"])
    grip = GRIP_SHARE * friction * GRAVITY
    a_y = p[f"{section}.a_y_max"]
    v_min = p[f"{section}.v_min"]
    tightest = math.tan(p["car.steering_limit"]) / p["car.wheelbase"]
    demand = v_min**2 * tightest
    radius = v_min**2 / grip
    return [
        LimitCheck(
            "grip in corners",
            "a_y_max",
            a_y,
            f"<= {grip:.2f}",
            "m/s²",
            a_y <= grip,
            f"0.8 μ g with μ = {friction:.2f}",
        ),
        LimitCheck(
            "grip at full lock",
            "v_min² κ_max",
            demand,
            f"< {grip:.2f}",
            "m/s²",
            demand < grip,
            f"turning radius at full lock {1.0 / tightest:.2f} m; v_min requires R >= {radius:.2f} m",
        ),
    ]


def _speed_loop(p: dict[str, float], vehicle: dict[str, float]) -> LimitCheck:
    """The speed step times the speed loop's gain is the braking it causes."""
    asked = -p["velocity_profile.delta_v_min"] * vehicle["speed_gain"]
    planned = -p["velocity_profile.a_x_min"]
    return LimitCheck(
        "braking of the speed loop",
        "|delta_v_min| · speed_gain",
        asked,
        f"<= {1.2 * planned:.2f}",
        "m/s²",
        asked <= 1.2 * planned,
        f"planned braking is {planned:.2f} m/s²",
    )
