"""The horizon: states and inputs over the next second, and their linearized dynamics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from firstlap.control.mpc.line_table import LineTable
from firstlap.control.mpc.model import ARRAYS, Model, motion
from firstlap.tracks.track import FloatArray

S, OFFSET, COURSE, VX, VY, RATE, WHEEL = range(7)
STATES = 7
COMMAND, ACCEL = range(2)
INPUTS = 2
NUDGE = 1e-5
SQUARINGS = 3
MOST_SLIP, MOST_FRONT_SLIP, MOST_COURSE = 0.15, 0.12, 0.8
UNIT_ACCEL = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


@dataclass(eq=False)
class Plan:
    """The plan from `time` [s] on, one column per stage of `step` seconds.

    states (7, N + 1): s, offset, heading error, vx, vy, yaw rate, steering angle. inputs (2, N): steering command
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

    def moved_to(self, time: float) -> Plan:
        """The same plan from a later time on, extended along the line."""
        place = (time - self.time) / self.step + np.arange(self.states.shape[1])
        last = self.states.shape[1] - 1
        index = np.clip(place.astype(np.intp), 0, last - 1)
        part = np.minimum(place - index, 1.0)
        states = self.states[:, index] * (1.0 - part) + self.states[:, index + 1] * part
        inputs = self.inputs[:, np.minimum(np.round(place[:-1]).astype(np.intp), last - 1)]
        beyond = np.maximum(place - last, 0.0) * self.step
        states[S] += beyond * states[VX]
        return Plan(time, self.step, states, inputs)


def derivative(model: Model, table: LineTable, x: FloatArray, u: FloatArray) -> FloatArray:
    """Time derivative of states (7, K) along the line for inputs (2, K)."""
    vx, vy, rate = x[VX], x[VY], x[RATE]
    # The servo stays linear: plans keep their commands within its reach.
    turning = (u[COMMAND] - x[WHEEL]) / model.servo
    ax, ay, spin = motion(model, vx, vy, rate, x[WHEEL], u[ACCEL], ARRAYS)
    across = vy - model.l_r * rate
    c, s = np.cos(x[COURSE]), np.sin(x[COURSE])
    bend = table.bend(x[S])
    way = (vx * c - across * s) / np.maximum(0.2, 1.0 - bend * x[OFFSET])
    out = np.empty_like(x)
    out[S], out[OFFSET], out[COURSE] = way, vx * s + across * c, rate - bend * way
    out[VX], out[VY], out[RATE], out[WHEEL] = ax, ay, spin, turning
    return out


def linearised(model: Model, table: LineTable, plan: Plan) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(A (N, 7, 7), B (N, 7, 2), r (N, 7)) with x' = A x + B u + r near the plan.

    Uses the matrix exponential at each stage: exact for the linearized car, whose slip settles within a stage.
    """
    x, u = plan.states[:, :-1], plan.inputs
    count, width = u.shape[1], STATES + INPUTS
    many_x = np.repeat(x[:, None, :], width + 1, axis=1)
    many_u = np.repeat(u[:, None, :], width + 1, axis=1)
    states, inputs = np.arange(STATES), np.arange(INPUTS)
    many_x[states, states + 1] += NUDGE
    many_u[inputs, STATES + inputs + 1] += NUDGE
    shape = (-1, (width + 1) * count)
    rates = derivative(model, table, many_x.reshape(shape), many_u.reshape(shape)).reshape(STATES, width + 1, count)
    slopes = ((rates[:, 1:] - rates[:, :1]) * (1.0 / NUDGE)).transpose(2, 0, 1)
    # What acceleration takes from the tires is the friction ellipse's matter: its slope, good only nearby, would
    # have the car brake in order to steer.
    slopes[:, :, STATES + ACCEL] = UNIT_ACCEL
    a, whole = exponential(slopes[:, :, :STATES], plan.step)
    b = whole @ slopes[:, :, STATES:]
    after = x.T + (whole @ rates[:, 0].T[:, :, None])[:, :, 0]
    rest = after - (a @ x.T[:, :, None])[:, :, 0] - (b @ u.T[:, :, None])[:, :, 0]
    return a, b, rest


def believable(plan: Plan, model: Model) -> Plan:
    """The plan with states at which the linearization is valid: slip below the tires' peak."""
    x = plan.states
    speed = np.maximum(x[VX], 1.0)
    x[VX] = np.maximum(x[VX], 0.0)
    x[COURSE] = np.clip(x[COURSE], -MOST_COURSE, MOST_COURSE)
    most = model.grip.lateral / speed
    x[RATE] = np.clip(x[RATE], -most, most)
    drift = np.clip(x[VY] - model.l_r * x[RATE], -MOST_SLIP * speed, MOST_SLIP * speed)
    x[VY] = drift + model.l_r * x[RATE]
    front = (x[VY] + model.l_f * x[RATE]) / speed
    x[WHEEL] = np.clip(x[WHEEL], front - MOST_FRONT_SLIP, front + MOST_FRONT_SLIP)
    x[WHEEL] = np.clip(x[WHEEL], -model.steering_limit, model.steering_limit)
    return plan


def exponential(slope: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
    """(exp(slope t), integral of exp(slope t') over 0 to t) for matrices (K, n, n): scaling and squaring.

    Accurate up to slopes of about 8 / t, since the yaw rate of a slow car settles within milliseconds.
    """
    one = np.eye(slope.shape[1])
    part = time / 2**SQUARINGS
    m = part * slope
    square = m @ m
    integral = part * (one + 0.5 * m + square @ (one / 6.0 + m / 24.0))
    e = one + slope @ integral
    for _ in range(SQUARINGS):
        integral = integral + e @ integral
        e = e @ e
    return e, integral


def first_plan(model: Model, table: LineTable, state: FloatArray, time: float, count: int, step: float) -> Plan:
    """An initial plan: along the line, toward its speeds, without slip."""
    states = np.zeros((STATES, count + 1))
    inputs = np.zeros((INPUTS, count))
    states[:, 0] = state
    s, v = float(state[S]), max(float(state[VX]), 0.0)
    for k in range(count):
        bend, wanted = (float(value) for value in table.at(np.array([s]))[0, :2])
        accel = min(max((wanted - v) / 0.3, -0.5 * model.most_brake), 0.5 * model.most_accel)
        wheel = min(max(np.arctan(model.wheelbase * bend), -model.steering_limit), model.steering_limit)
        inputs[:, k] = wheel, accel
        s, v = s + v * step, max(v + accel * step, 0.0)
        fade = np.exp(-0.1 * (k + 1))
        states[:, k + 1] = s, state[OFFSET] * fade, state[COURSE] * fade, v, model.l_r * v * bend, v * bend, wheel
    return Plan(time, step, states, inputs)
