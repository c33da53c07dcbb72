"""The horizon: states and inputs over the next second, moved along in time, and their linearised dynamics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firstlap.mpc.line_table import LineTable
from firstlap.mpc.model import ARRAYS, Model, motion
from firstlap.tracks.track import FloatArray

S, OFFSET, COURSE, VX, VY, RATE, WHEEL = range(7)
STATES = 7
COMMAND, ACCEL = range(2)
INPUTS = 2
SUBSTEPS = 2
NUDGE = 1e-5


@dataclass(eq=False)
class Plan:
    """What the car is going to do from `time` [s] on, one column per stage of `step` seconds.

    states (7, N + 1): s, offset, heading error, vx, vy, yaw rate, wheel angle. inputs (2, N): steering command
    [rad], acceleration [m/s^2].
    """

    time: float
    step: float
    states: FloatArray
    inputs: FloatArray

    def input_at(self, time: float) -> tuple[float, float]:
        """Steering command and acceleration at a time, held outside of the plan."""
        place = (time - self.time) / self.step
        k = min(max(0, int(place + 1e-6)), self.inputs.shape[1] - 1)
        return float(self.inputs[COMMAND, k]), float(self.inputs[ACCEL, k])

    def moved_to(self, time: float, model: Model, table: LineTable) -> Plan:
        """The same intent from a later time on; the end is driven on with the last input."""
        place = (time - self.time) / self.step + np.arange(self.states.shape[1])
        last = self.states.shape[1] - 1
        index = np.clip(place.astype(np.intp), 0, last - 1)
        part = np.minimum(place - index, 1.0)
        states = self.states[:, index] * (1.0 - part) + self.states[:, index + 1] * part
        inputs = self.inputs[:, np.minimum(np.round(place[:-1]).astype(np.intp), last - 1)]
        first_new = int(np.searchsorted(place, last + 1e-9))
        for k in range(max(first_new, 1), last + 1):
            states[:, k] = advance(model, table, states[:, k - 1 : k], inputs[:, k - 1 : k], self.step)[:, 0]
        return Plan(time, self.step, states, inputs)


def derivative(model: Model, table: LineTable, x: FloatArray, u: FloatArray) -> FloatArray:
    """Time derivative of states (7, K) along the line for inputs (2, K)."""
    vx, vy, rate = x[VX], x[VY], x[RATE]
    ax, ay, spin, turning = motion(model, vx, vy, rate, x[WHEEL], u[COMMAND], u[ACCEL], ARRAYS)
    across = vy - model.l_r * rate
    c, s = np.cos(x[COURSE]), np.sin(x[COURSE])
    bend = table.bend(x[S])
    way = (vx * c - across * s) / np.maximum(0.2, 1.0 - bend * x[OFFSET])
    out = np.empty_like(x)
    out[S], out[OFFSET], out[COURSE] = way, vx * s + across * c, rate - bend * way
    out[VX], out[VY], out[RATE], out[WHEEL] = ax, ay, spin, turning
    return out


def advance(model: Model, table: LineTable, x: FloatArray, u: FloatArray, time: float) -> FloatArray:
    """States (7, K) after `time` [s], Runge-Kutta 4."""
    h = time / SUBSTEPS
    for _ in range(SUBSTEPS):
        k1 = derivative(model, table, x, u)
        k2 = derivative(model, table, x + 0.5 * h * k1, u)
        k3 = derivative(model, table, x + 0.5 * h * k2, u)
        k4 = derivative(model, table, x + h * k3, u)
        x = x + (h / 6.0) * (k1 + 2.0 * (k2 + k3) + k4)
    return x


def linearised(model: Model, table: LineTable, plan: Plan) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(A (N, 7, 7), B (N, 7, 2), r (N, 7)) with x' = A x + B u + r near the plan."""
    x, u = plan.states[:, :-1], plan.inputs
    count, width = u.shape[1], STATES + INPUTS
    many_x = np.repeat(x[:, None, :], width + 1, axis=1)
    many_u = np.repeat(u[:, None, :], width + 1, axis=1)
    for i in range(STATES):
        many_x[i, i + 1] += NUDGE
    for i in range(INPUTS):
        many_u[i, STATES + i + 1] += NUDGE
    shape = (-1, (width + 1) * count)
    after = advance(model, table, many_x.reshape(shape), many_u.reshape(shape), plan.step)
    after = after.reshape(STATES, width + 1, count)
    slopes = (after[:, 1:] - after[:, :1]) / NUDGE
    a = slopes[:, :STATES].transpose(2, 0, 1)
    b = slopes[:, STATES:].transpose(2, 0, 1)
    rest = after[:, 0].T - np.einsum("kij,jk->ki", a, x) - np.einsum("kij,jk->ki", b, u)
    return a, b, rest


def first_plan(model: Model, table: LineTable, state: FloatArray, time: float, count: int, step: float) -> Plan:
    """A plan from nothing: along the line, towards its speeds, without slip."""
    states = np.zeros((STATES, count + 1))
    inputs = np.zeros((INPUTS, count))
    states[:, 0] = state
    s, v = float(state[S]), max(float(state[VX]), 0.0)
    for k in range(count):
        bend, wanted = (float(value) for value in table.at(np.array([s]))[0, :2])
        accel = min(max((wanted - v) / 0.3, -0.5 * model.grip), 0.5 * model.grip)
        wheel = min(max(np.arctan(model.wheelbase * bend), -model.steering_limit), model.steering_limit)
        inputs[:, k] = wheel, accel
        s, v = s + v * step, max(v + accel * step, 0.0)
        fade = np.exp(-0.1 * (k + 1))
        states[:, k + 1] = s, state[OFFSET] * fade, state[COURSE] * fade, v, model.l_r * v * bend, v * bend, wheel
    return Plan(time, step, states, inputs)
