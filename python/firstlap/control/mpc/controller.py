"""Model predictive control along a racing line: one pose and state in, one command out."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np

from firstlap._core import VehicleState
from firstlap.config.car_file import Car
from firstlap.control.mpc.horizon import OFFSET, Plan, S, believable, first_plan, linearised
from firstlap.control.mpc.line_table import LineTable
from firstlap.control.mpc.model import model_of
from firstlap.control.mpc.observer import Body, Commands, corrected, finite, predicted, standing
from firstlap.control.mpc.params import MpcParams
from firstlap.control.mpc.problem import Problem
from firstlap.perception.scan import USUAL_PERIOD
from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.line import RaceLine
from firstlap.tracks.track import FloatArray, Track

FASTEST = 60.0
"""[m/s] Maximum plausible measured speed."""
FIRST_ROUNDS = 3
TICK = 1e-9


class Step(NamedTuple):
    """A command: speed [m/s] and steering_angle [rad], left positive; status: its reason."""

    speed: float
    steering_angle: float
    status: str


class Controller:
    """Tracks a line with a model of the car's dynamics, limits and delays. Call `step` once per measurement.

    status of a step: ok, holding (no pose, or no plan in time: the last plan is followed), no_path (for too long, or
    far from the line: braking to a stop), bad_state (no measurement: stop).

    braking: if set, a stop with this deceleration [m/s^2] is planned instead of the line's speeds.
    acting: speed [m/s] of the car when the next speed command acts, and the distance [m] until then.
    """

    def __init__(
        self,
        line: RaceLine,
        track: Track,
        car: Car,
        params: MpcParams | None = None,
        clock: Callable[[], float] = perf_counter,
    ) -> None:
        """track: its walls bound the plans. clock: for the time limit. Raises InputError."""
        self.params = params or MpcParams()
        self.model = model_of(car, self.params.mu)
        self.table = LineTable(line, Corridor(track, car), self.params.margin)
        self._clock = clock
        self._solver = Problem(self.model, self.params, self.table.zones)
        self.reset()

    def reset(self) -> None:
        """Resets the memory."""
        self.time = 0.0
        self.body: Body | None = None
        self.plan: Plan | None = None
        self._commands = Commands()
        self._planned_at = -math.inf
        self._pose_at = -math.inf
        self._place: float | None = None
        self._last = Step(0.0, 0.0, "ok")
        self.acting = (0.0, 0.0)
        self.braking: float | None = None

    def step(
        self,
        pose: tuple[float, float, float] | None,
        measured: VehicleState,
        dt: float,
        pose_age: float = 0.0,
    ) -> Step:
        """One command. Does not raise for invalid data.

        pose: x, y, yaw of base_link in the track's frame, measured `pose_age` seconds ago; None or not finite if
        there is none. measured: now. dt: seconds since the last.
        """
        begin = self._clock()
        dt = dt if math.isfinite(dt) and 0.0 < dt < 1.0 else USUAL_PERIOD
        speed = measured.speed
        self._observe(pose, (speed, measured.yaw_rate, measured.steering_angle), dt, pose_age)
        if self.body is None:
            self.acting = (speed if math.isfinite(speed) else 0.0, 0.0)
            return self._give(Step(0.0, 0.0, "bad_state"), self.time + self.params.latency)
        felt = self.time + self.params.latency
        ahead = predicted(self.model, self.body, self._commands, self.time, felt + self.model.speed_delay)
        self.acting = ahead[3], math.hypot(ahead[0] - self.body[0], ahead[1] - self.body[1])
        if self.time - self._pose_at > self.params.patience + TICK:
            return self._stop(ahead, felt, "no_path")
        speed_command = self._speed_command(ahead, felt, dt)
        self._commands.give_speed(felt + self.model.speed_delay, speed_command)
        acting = felt + max(self.model.steering_delay, self.model.speed_delay)
        planned = self._replan(self._at(ahead, felt, acting), acting, begin)
        return self._command(planned, speed_command, felt, acting, ahead)

    def replace(self, speed: float, steering_angle: float) -> None:
        """Replaces the last step's command by the one actually sent."""
        self._give(Step(speed, steering_angle, self._last.status), self.time + self.params.latency)

    def _command(self, planned: bool, speed_command: float, felt: float, acting: float, ahead: Body) -> Step:
        late = self.time - self._planned_at > self.params.patience + TICK
        if self.plan is None or late or self._off_line:
            return self._stop(ahead, felt, "no_path")
        steering = self.plan.input_at(acting)[0]
        fresh = planned and self._pose_at == self.time
        return self._give(Step(speed_command, steering, "ok" if fresh else "holding"), felt, speed_given=True)

    def _observe(
        self, pose: tuple[float, float, float] | None, state: tuple[float, float, float], dt: float, pose_age: float
    ) -> None:
        """Predicts the estimate and corrects it with plausible measurements."""
        good_pose = pose if pose is not None and finite(pose) else None
        good_state = state if finite(state, FASTEST) else None
        begin, self.time = self.time, self.time + dt
        if self.body is None:
            if good_pose is not None and good_state is not None:
                self.body = standing(good_pose, good_state, self.model)
        else:
            body = predicted(self.model, self.body, self._commands, begin, self.time)
            age = pose_age if math.isfinite(pose_age) else 0.0
            self.body = corrected(self.model, body, good_pose, age, good_state, self.params)
        if good_pose is not None and good_state is not None:
            self._pose_at = self.time

    def _at(self, ahead: Body, felt: float, acting: float) -> Body:
        return predicted(self.model, ahead, self._commands, felt + self.model.speed_delay, acting)

    def _speed_command(self, ahead: Body, felt: float, dt: float) -> float:
        """The speed command for which the car's speed loop gives the planned mean acceleration until the next step."""
        at = felt + self.model.speed_delay + 0.5 * dt
        accel = 0.0 if self.plan is None else self.plan.input_at(at)[1]
        gain = self.model.gain_up if accel > 0.0 else self.model.gain_down
        return max(0.0, ahead[3] + accel * (1.0 / gain + 0.5 * dt))

    def _replan(self, body: Body, acting: float, begin: float) -> bool:
        """Plans from `acting` on; returns whether there is a new plan in time."""
        s, offset, error = self.table.locate(body[0], body[1], body[2], self._place)
        self._place = s
        self._off_line = abs(offset) > self.params.lost_offset or abs(error) > 0.5 * math.pi
        state = np.array([s, offset, error, *body[3:]])
        if self._off_line or not finite(state):
            return False
        plan, rounds = self._guess(state, acting)
        found: Plan | None = None
        for _ in range(rounds):
            before = self._commands.steering(acting), plan.inputs[1, 0]
            dynamics = linearised(self.model, self.table, believable(plan, self.model))
            self._solver.fill(plan, dynamics, state, before, self.table, self.braking)
            solved = self._solver.solve()
            if solved is None:
                return False
            plan = found = Plan(acting, self.params.stage_time, *solved)
        if self._clock() - begin > self.params.time_limit and self.plan is not None:
            return False
        self.plan, self._planned_at = found, self.time
        return True

    def _guess(self, state: FloatArray, acting: float) -> tuple[Plan, int]:
        """The plan to linearize about: the last one moved on, or a new one if that does not fit."""
        if self.plan is not None and self.time - self._planned_at <= self.params.patience:
            moved = self.plan.moved_to(acting)
            lap = self.table.length
            moved.states[S] += lap * round((state[S] - moved.states[S, 0]) / lap)
            if abs(moved.states[S, 0] - state[S]) < 1.0 and abs(moved.states[OFFSET, 0] - state[OFFSET]) < 0.5:
                return moved, 1
        stages, step = self.params.stages, self.params.stage_time
        return first_plan(self.model, self.table, state, acting, stages, step), FIRST_ROUNDS

    def _stop(self, ahead: Body, felt: float, status: str) -> Step:
        """Brakes without locking the wheels, along the rest of the last plan."""
        speed = max(0.0, ahead[3] - self.params.stop_brake / self.model.gain_down)
        speed = speed if speed > 0.3 else 0.0
        steering = self._last.steering_angle
        if self.plan is not None:
            steering = self.plan.input_at(felt + self.model.steering_delay)[0]
        return self._give(Step(speed, steering, status), felt)

    def _give(self, step: Step, felt: float, speed_given: bool = False) -> Step:
        """Stores the command for the next prediction."""
        most = self.model.steering_limit
        step = Step(step.speed, min(max(step.steering_angle, -most), most), step.status)
        if not speed_given:
            self._commands.give_speed(felt + self.model.speed_delay, step.speed)
        self._commands.give_steering(felt + self.model.steering_delay, step.steering_angle)
        self._last = step
        return step

    _off_line = False
