"""The quadratic program of one control step, with a fixed pattern whose values are filled in place."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstlap.control.mpc.horizon import ACCEL, COMMAND, COURSE, INPUTS, OFFSET, RATE, STATES, VX, VY, WHEEL, Plan, S
from firstlap.control.mpc.line_table import ZONES, LineTable
from firstlap.control.mpc.model import Model
from firstlap.control.mpc.params import MpcParams
from firstlap.control.mpc.pattern import Pattern
from firstlap.planning.raceline.quadratic import FREE, solver_class
from firstlap.tracks.track import FloatArray

TANGENTS = np.array([-0.5, 0.0, 0.5])
SIDES = np.array([-0.5 * np.pi, 0.5 * np.pi])
"""[rad] Angles of the tangents of the friction ellipse: near the plan's point, and to both sides."""
BLOCK = STATES + INPUTS + 2
SLACKS = 2
TERMINAL = 5.0
HOLD = 1e-6
NEAR = 0.15
JOIN_LEAST = 2.0
JOIN_TIME = 0.7
"""[m], [m], [s]: farther than NEAR from the line the car joins it within JOIN_LEAST and JOIN_TIME of travel."""


class Problem:
    """Minimizes the tracking cost over the horizon under dynamics, actuator limits, and soft grip and wall limits."""

    def __init__(self, model: Model, params: MpcParams, zones: FloatArray) -> None:
        self.model, self.params = model, params
        n = self.n = params.stages
        self._base = BLOCK * np.arange(n + 1)
        self.size = BLOCK * n + STATES + 1
        self._zones = zones
        self._solver: Any = None
        self._linear = np.zeros(self.size)
        self._low, self._high = np.full(self.size, -FREE), np.full(self.size, FREE)
        self._make_cost()
        self._make_dynamics()
        self._make_rows()
        self._bound()

    def _state(self, which: int) -> Any:
        return self._base + which

    def _input(self, which: int) -> Any:
        return self._base[:-1] + STATES + which

    @property
    def _wall_slack(self) -> Any:
        return np.append(self._base[:-1] + STATES + INPUTS, self.size - 1)

    @property
    def _grip_slack(self) -> Any:
        return self._base[:-1] + STATES + INPUTS + 1

    def _make_cost(self) -> None:
        p, cost = self.params, Pattern(self.size, self.size)
        every = cost.group(np.arange(self.size), np.arange(self.size))
        offset = cost.group(self._state(OFFSET), self._state(OFFSET))
        course = (self._state(COURSE), self._state(VY), self._state(RATE))
        pairs = [(i, j) for i in range(3) for j in range(i, 3)]
        self._course = [(cost.group(course[i], course[j]), i, j) for i, j in pairs]
        self._speed = cost.group(self._state(VX), self._state(VX))
        self._speed_s = cost.group(self._state(S), self._state(VX))
        self._speed_ss = cost.group(self._state(S), self._state(S))
        changes = [
            (cost.group(self._input(i), self._input(i)), cost.group(self._input(i)[:-1], self._input(i)[1:]), weight)
            for i, weight in ((COMMAND, p.q_steering), (ACCEL, p.q_accel))
        ]
        near = [cost.group(self._input(i), self._input(i)) for i in (COMMAND, ACCEL)]
        slacks = cost.group(self._grip_slack, self._grip_slack), cost.group(self._wall_slack, self._wall_slack)
        cost.freeze()
        cost.values[every] = HOLD
        cost.values[offset] = p.q_offset
        cost.values[offset.stop - 1] *= TERMINAL
        self._offset_weight = cost.values[offset].copy()
        for diagonal, beside, weight in changes:
            cost.values[diagonal] = 2.0 * weight
            cost.values[diagonal.stop - 1] = weight
            cost.values[beside] = -weight
        cost.values[near[0]], cost.values[near[1]] = p.near_steering, p.near_accel
        cost.values[slacks[0]], cost.values[slacks[1]] = 0.1 * p.grip_price, p.wall_price
        self._cost = cost
        self._linear[self._wall_slack], self._linear[self._grip_slack] = p.wall_price, p.grip_price

    def _make_dynamics(self) -> None:
        n, even = self.n, Pattern(STATES * (self.n + 1), self.size)
        row = STATES * np.arange(n + 1)[:, None, None] + np.arange(STATES)[:, None]
        now = self._base[:-1, None, None]
        first = even.group(np.arange(STATES), np.arange(STATES))
        after = even.group(row[1:, :, 0], self._base[1:, None] + np.arange(STATES))
        self._a = even.group(row[1:], now + np.arange(STATES))
        self._b = even.group(row[1:], now + STATES + np.arange(INPUTS))
        even.freeze()
        even.values[first], even.values[after] = 1.0, 1.0
        self._even, self._even_to = even, np.zeros(STATES * (n + 1))

    def _make_rows(self) -> None:
        n, tangents = self.n, len(TANGENTS) + len(SIDES)
        walls = 2 * ZONES
        rows = Pattern(n * (1 + tangents + walls), self.size)
        stage = np.arange(n)
        commands, wheels = rows.group(stage, self._input(COMMAND)), rows.group(stage, self._state(WHEEL)[:-1])
        grip = n + stage[:, None] * tangents + np.arange(tangents)
        self._grip_a = rows.group(grip, self._input(ACCEL)[:, None])
        self._grip_v = rows.group(grip, self._state(VX)[:-1, None])
        self._grip_r = rows.group(grip, self._state(RATE)[:-1, None])
        grip_slack = rows.group(grip, self._grip_slack[:, None])
        wall = n * (1 + tangents) + stage[:, None] * walls + np.arange(walls)
        offset = rows.group(wall, self._state(OFFSET)[1:, None])
        course = rows.group(wall, self._state(COURSE)[1:, None])
        wall_slack = rows.group(wall, self._wall_slack[1:, None])
        rows.freeze()
        rows.values[commands], rows.values[wheels] = 1.0, -1.0
        rows.values[grip_slack], rows.values[wall_slack] = -1.0, -1.0
        side = np.repeat([1.0, -1.0], ZONES)
        rows.values[offset] = np.tile(side, n)
        rows.values[course] = np.tile(side * np.tile(self._zones, 2), n)
        self._rows = rows
        self._rows_low = np.full(n * (1 + tangents + walls), -FREE)
        self._rows_high = np.full(n * (1 + tangents + walls), FREE)
        most = self.model.servo_reach
        self._rows_low[:n], self._rows_high[:n] = -most, most
        self._grip_to = slice(n, n * (1 + tangents))
        self._wall_to = slice(n * (1 + tangents), None)

    def _bound(self) -> None:
        model = self.model
        wheel, accel = self._input(COMMAND), self._input(ACCEL)
        self._low[wheel], self._high[wheel] = -model.steering_limit, model.steering_limit
        self._low[accel], self._high[accel] = -model.most_brake, model.most_accel
        self._low[self._wall_slack] = self._low[self._grip_slack] = 0.0

    def fill(
        self,
        plan: Plan,
        dynamics: tuple[FloatArray, FloatArray, FloatArray],
        start: FloatArray,
        before: tuple[float, float],
        table: LineTable,
        braking: float | None = None,
    ) -> None:
        """Sets the values of one step: a plan to linearize about, its dynamics, the initial state (7,), and
        the inputs in effect before it. braking [m/s^2]: deceleration of a planned stop."""
        a, b, rest = dynamics
        self._even.values[self._a], self._even.values[self._b] = -a.ravel(), -b.ravel()
        self._even_to[:STATES], self._even_to[STATES:] = start, rest.ravel()
        self._fill_cost(plan, before, table, braking)
        self._fill_rows(plan)

    def _fill_cost(self, plan: Plan, before: tuple[float, float], table: LineTable, braking: float | None) -> None:
        p, x = self.params, plan.states
        reference = table.at(x[S])
        step = 0.05
        slope = p.speed_scale * (table.at(x[S] + step)[:, 1] - reference[:, 1]) / step
        aim = p.speed_scale * reference[:, 1] - slope * x[S]
        if braking is not None:
            slope = np.zeros_like(slope)
            aim = np.maximum(0.0, x[VX, 0] - braking * plan.step * np.arange(self.n + 1))
        self._reference = reference
        weight = np.full(self.n + 1, p.q_speed)
        weight[-1] *= TERMINAL
        forward = np.maximum(x[VX], 1.0)
        course = (np.ones(self.n + 1), 1.0 / forward, -self.model.l_r / forward)
        for place, i, j in self._course:
            self._cost.values[place] = p.q_course * course[i] * course[j]
        self._cost.values[self._speed], self._cost.values[self._speed_s] = weight, -weight * slope
        self._cost.values[self._speed_ss] = weight * slope**2
        self._linear[self._state(VX)], self._linear[self._state(S)] = -weight * aim, weight * aim * slope
        self._linear[self._state(OFFSET)] = -self._offset_weight * self._joining(x)
        self._linear[self._input(COMMAND)] = -p.near_steering * plan.inputs[COMMAND]
        self._linear[self._input(ACCEL)] = -p.near_accel * plan.inputs[ACCEL]
        self._linear[self._input(COMMAND)[0]] -= p.q_steering * before[COMMAND]
        self._linear[self._input(ACCEL)[0]] -= p.q_accel * before[ACCEL]

    def _joining(self, x: FloatArray) -> FloatArray:
        """Reference offset from the line (N + 1,): from far away the car joins it gradually."""
        start = float(x[OFFSET, 0])
        far = np.sign(start) * max(0.0, abs(start) - NEAR)
        way = (x[S] - x[S, 0]) / (JOIN_LEAST + JOIN_TIME * max(float(x[VX, 0]), 0.0))
        return np.asarray(far * (1.0 - np.minimum(way, 1.0)) ** 2)

    def _fill_rows(self, plan: Plan) -> None:
        grip, use = self.model.grip, self.params.grip_use
        v, r, a = plan.states[VX, :-1], plan.states[RATE, :-1], plan.inputs[ACCEL]
        axis = np.where(a > 0.0, grip.drive, grip.brake)
        angle = np.arctan2(v * r / grip.lateral, a / axis)[:, None] + TANGENTS
        angle = np.hstack([angle, np.broadcast_to(SIDES, (self.n, len(SIDES)))])
        c, s = np.cos(angle), np.sin(angle) / (use * grip.lateral)
        c /= use * np.where(c > 0.0, grip.drive, grip.brake)
        self._rows.values[self._grip_a] = c.ravel()
        self._rows.values[self._grip_v] = (s * r[:, None]).ravel()
        self._rows.values[self._grip_r] = (s * v[:, None]).ravel()
        self._rows_high[self._grip_to] = (1.0 + s * (v * r)[:, None]).ravel()
        self._rows_high[self._wall_to] = self._reference[1:, 2:].ravel()

    def solve(self) -> tuple[FloatArray, FloatArray] | None:
        """States (7, N + 1) and inputs (2, N) at the minimum; None if the solver failed."""
        arguments = (
            self._cost.fill(),
            self._linear,
            self._even.fill(),
            self._even_to,
            self._rows.fill(),
            self._rows_low,
            self._rows_high,
            self._low,
            self._high,
        )
        if self._solver is None:
            self._solver = solver_class()()
            self._solver.settings.max_iter = 40
            self._solver.settings.eps_abs = 1e-5
            self._solver.settings.eps_rel = 1e-6
            self._solver.setup(*arguments)
        else:
            self._solver.update(*arguments)
        if self._solver.solve().name != "PIQP_SOLVED":
            return None
        z = np.asarray(self._solver.result.x)
        blocks = z[: BLOCK * self.n].reshape(self.n, BLOCK)
        last = z[BLOCK * self.n : BLOCK * self.n + STATES]
        states = np.vstack([blocks[:, :STATES], last]).T.copy()
        inputs = blocks[:, STATES : STATES + INPUTS].T.copy()
        if not (np.isfinite(states).all() and np.isfinite(inputs).all()):
            return None
        return states, inputs
