"""What the predictive controller weighs and may do: the only place where its defaults stand."""

from __future__ import annotations

from dataclasses import dataclass

from firstlap.config.table import row, table_of


@dataclass(frozen=True)
class MpcParams:
    """The controller's parameters. See docs/parameters.md."""

    stages: int = row(30, "", 5, 100, "steps of the horizon")
    stage_time: float = row(0.03, "s", 0.01, 0.1, "length of a step of the horizon")
    mu: float = row(0.0, "", 0.0, 3.0, "friction of the model; 0 takes the car's")
    grip_use: float = row(0.95, "", 0.1, 1.2, "share of the tires' grip that a plan may use before it pays")
    margin: float = row(0.05, "m", 0.0, 0.5, "room to the walls below which a plan pays")
    speed_scale: float = row(1.0, "", 0.1, 1.5, "times the speeds of the line")
    q_offset: float = row(20.0, "1/m^2", 0.0, 1e4, "weight of the distance from the line")
    q_course: float = row(2.0, "1/rad^2", 0.0, 1e4, "weight of the angle between the car's motion and the line")
    q_speed: float = row(0.5, "s^2/m^2", 0.0, 1e4, "weight of the difference to the line's speed")
    q_steering: float = row(60.0, "1/rad^2", 0.0, 1e4, "weight of a change of the wheel angle between stages")
    q_accel: float = row(0.01, "s^4/m^2", 0.0, 1e4, "weight of a change of the acceleration between stages")
    near_steering: float = row(80.0, "1/rad^2", 0.0, 1e4, "weight of a change of the wheel angle from plan to plan")
    near_accel: float = row(0.02, "s^4/m^2", 0.0, 1e4, "weight of a change of the acceleration from plan to plan")
    wall_price: float = row(100.0, "1/m", 0.0, 1e6, "price of each meter nearer to a wall than the margin")
    grip_price: float = row(3.0, "", 0.0, 1e6, "price of grip beyond its share")
    latency: float = row(0.005, "s", 0.0, 0.3, "from the measurement to the command, computing included")
    place_gain: float = row(0.5, "", 0.01, 1.0, "share of a new pose's place in the estimate; the rest is the model's")
    heading_gain: float = row(0.5, "", 0.01, 1.0, "share of a new pose's heading in the estimate")
    drift_gain: float = row(2.0, "1/s", 0.0, 20.0, "lateral speed per meter that a pose is beside the expected one")
    state_gain: float = row(0.5, "", 0.01, 1.0, "share of measured speed, yaw rate and wheel angle in the estimate")
    time_limit: float = row(0.02, "s", 0.001, 1.0, "a plan that takes longer is late: the last one is followed")
    patience: float = row(0.3, "s", 0.0, 2.0, "how long the last plan is followed before the car stops")
    stop_brake: float = row(3.0, "m/s^2", 0.1, 20.0, "deceleration of that stop")
    lost_offset: float = row(2.5, "m", 0.1, 10.0, "farther than this from the line the car stops")


MPC_FIELDS = table_of(mpc=MpcParams)
