"""Parameters of the predictive controller."""

from __future__ import annotations

from dataclasses import dataclass

from firstlap.config.table import row, table_of


@dataclass(frozen=True)
class MpcParams:
    """The controller's parameters. See docs/parameters.md."""

    stages: int = row(30, "", 5, 100, "stages of the horizon")
    stage_time: float = row(0.03, "s", 0.01, 0.1, "duration of a stage")
    mu: float = row(0.0, "", 0.0, 3.0, "friction of the model (0: the car's)")
    grip_use: float = row(0.95, "", 0.1, 1.2, "share of the tires' grip that a plan may use without penalty")
    margin: float = row(0.05, "m", 0.0, 0.5, "clearance to the walls below which a plan is penalized")
    speed_scale: float = row(1.0, "", 0.1, 1.5, "scale of the line's speeds")
    q_offset: float = row(20.0, "1/m^2", 0.0, 1e4, "weight of the distance from the line")
    q_course: float = row(2.0, "1/rad^2", 0.0, 1e4, "weight of the angle between the car's motion and the line")
    q_speed: float = row(0.5, "s^2/m^2", 0.0, 1e4, "weight of the difference to the line's speed")
    q_steering: float = row(60.0, "1/rad^2", 0.0, 1e4, "weight of changes of the steering angle between stages")
    q_accel: float = row(0.01, "s^4/m^2", 0.0, 1e4, "weight of changes of the acceleration between stages")
    near_steering: float = row(
        80.0, "1/rad^2", 0.0, 1e4, "weight of changes of the steering angle between successive plans"
    )
    near_accel: float = row(0.02, "s^4/m^2", 0.0, 1e4, "weight of changes of the acceleration between successive plans")
    wall_price: float = row(100.0, "1/m", 0.0, 1e6, "penalty per meter of missing clearance")
    grip_price: float = row(3.0, "", 0.0, 1e6, "penalty of grip used beyond grip_use")
    latency: float = row(0.005, "s", 0.0, 0.3, "time from measurement to command, including computation")
    place_gain: float = row(0.5, "", 0.01, 1.0, "observer gain of the measured position")
    heading_gain: float = row(0.5, "", 0.01, 1.0, "observer gain of the measured heading")
    drift_gain: float = row(2.0, "1/s", 0.0, 20.0, "observer gain from lateral position error to lateral speed")
    state_gain: float = row(0.5, "", 0.01, 1.0, "observer gain of measured speed, yaw rate and steering angle")
    time_limit: float = row(
        0.02, "s", 0.001, 1.0, "a plan that takes longer is discarded, and the last one is followed"
    )
    patience: float = row(0.3, "s", 0.0, 2.0, "how long the last plan is followed before the car stops")
    stop_brake: float = row(3.0, "m/s^2", 0.1, 20.0, "deceleration of the stop when no recent plan is left")
    lost_offset: float = row(2.5, "m", 0.1, 10.0, "the car stops if it is farther than this from the line")


MPC_FIELDS = table_of(mpc=MpcParams)
