"""The minimum-time line: a sequence of quadratic programs in lateral shift and squared speed.

Unknowns are a shift and b = v^2 per point. The lap time is convex in b; acceleration and b k are linearized about
the last line with its exact profile, the friction ellipse is replaced by tangents near where the car is on it. A
step is taken only if the lap time of the shifted line's exact profile falls; otherwise the next step is shorter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import sparse

from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.params import Limits, LineParams
from firstlap.planning.raceline.quadratic import FREE, Program
from firstlap.planning.raceline.shape import Shape, constrain, shape_of, shift
from firstlap.planning.raceline.velocity import Profile, profile
from firstlap.tracks.track import FloatArray

FARTHEST = 0.4
FIRST_TRUST, ENOUGH = 0.5, 0.01
"""A step may change lateral acceleration by this share of the grip, v^2 by half this share, and at full trust move a
point by FARTHEST [m]: the product of the two changes, which the program does not see, stays small everywhere."""
CALM, CALM_STEPS = 3e-5, 3
"""This many consecutive steps that gain less than this share of the lap end the search."""
COARSE = (3.0, 1.0)
"""Spacings of the search, in order, as multiples of the final one."""
TANGENTS = (-0.3, 0.0, 0.3)
RING = tuple(np.pi * (i + 0.5) / 4.0 for i in range(8))
"""[rad] Angles of the tangents of the ellipse: near the current point, and all around, since a corner may change
side."""
SLOWEST, SLOWEST_JERK = 0.3, 2.0


def minimum_time(
    points: FloatArray, corridor: Corridor, limits: Limits, params: LineParams, tell: Callable[[float], None]
) -> FloatArray:
    """Points (N, 2) of the minimum-time line, from a closed, nearly feasible initial guess (M, 2).

    tell: called with the progress after each step.
    """
    for stage, factor in enumerate(COARSE):

        def say(share: float, stage: int = stage) -> None:
            tell((stage + share) / len(COARSE))

        points = _search(points, corridor, limits, replace(params, spacing=factor * params.spacing), say)
    return points


def _search(
    points: FloatArray, corridor: Corridor, limits: Limits, params: LineParams, tell: Callable[[float], None]
) -> FloatArray:
    shape = shape_of(points, corridor, limits, params)
    speeds = profile(shape.path.curvature, shape.path.step, limits)
    trust, calm = FIRST_TRUST, 0
    for number in range(params.time_rounds):
        tell(number / params.time_rounds)
        by = _step(shape, speeds, trust, params.smoothness)
        better = -1.0
        if by is not None:
            trial = shape_of(shift(shape, by), corridor, limits, params)
            trial_speeds = profile(trial.path.curvature, trial.path.step, limits)
            cost = _cost(shape, speeds, params.smoothness)
            better = cost - _cost(trial, trial_speeds, params.smoothness)
            calm = calm + 1 if better < CALM * cost else 0
            if better > 0.0:
                shape, speeds = trial, trial_speeds
        trust = min(1.0, 1.5 * trust) if better > 0.0 else 0.4 * trust
        if trust < ENOUGH or calm >= CALM_STEPS:
            break
    return shape.path.points


def _cost(shape: Shape, speeds: Profile, smoothness: float) -> float:
    bend, step = shape.path.curvature, shape.path.step
    change = (np.roll(bend, -1) - bend) / step
    return speeds.time + smoothness * float(np.sum(_jerk_weight(speeds) * change**2 * step)) + shape.cost


def _jerk_weight(speeds: Profile) -> FloatArray:
    """The weight that converts an integrated squared change of curvature to squared lateral jerk over time."""
    return np.asarray(np.maximum(0.5 * (speeds.speed + np.roll(speeds.speed, -1)), SLOWEST_JERK) ** 5)


def _step(shape: Shape, speeds: Profile, trust: float, smoothness: float) -> FloatArray | None:
    """The shift (N,) [m] of one quadratic program."""
    count = len(shape.path.points)
    program = Program(count, ("shift", "square", "short", "sharp"))
    constrain(program, shape, FARTHEST * min(1.0, 2.0 * trust))
    _add_time(program, shape, speeds)
    square = np.maximum(speeds.speed, SLOWEST) ** 2
    program.bound("square", np.maximum(SLOWEST**2, (1.0 - 0.5 * trust) * square), (1.0 + 0.5 * trust) * square)
    program.high[program.part("square")] = np.minimum(
        program.high[program.part("square")], np.maximum(shape.limits.speed**2, square)
    )
    most = trust * shape.limits.grip.lateral / square
    program.add_rows(program.across(shift=shape.reply.curvature), -most, most)
    _add_ellipse(program, shape, speeds)
    one = sparse.identity(count, format="csr")
    step = float(shape.path.step.mean())
    ahead = _ahead(count) - one
    now = shape.path.curvature
    root = np.sqrt(_jerk_weight(speeds))
    bends = sparse.diags(root) @ ahead @ shape.reply.curvature
    program.add_squares(program.across(shift=bends), -root * (np.roll(now, -1) - now), 2.0 * smoothness / step)
    program.add_squares(program.across(shift=one), np.zeros(count), 1e-4 * step)
    for block in ("short", "sharp"):
        program.add_squares(program.across(**{block: one}), np.zeros(count), 1e-3)
    solved = program.solve()
    return None if solved is None else solved["shift"]


def _ahead(count: int) -> sparse.csr_matrix:
    """The matrix that selects each point's successor on the lap."""
    here = np.arange(count)
    return sparse.csr_matrix((np.ones(count), (here, (here + 1) % count)), shape=(count, count))


def _add_time(program: Program, shape: Shape, speeds: Profile) -> None:
    """sum 2 step / (v + v'), to first order in the shift and second order in b."""
    v, step = np.maximum(speeds.speed, SLOWEST), shape.path.step
    total = v + np.roll(v, -1)
    slope = -step / (v * total**2)
    slope_after = -step / (np.roll(v, -1) * total**2)
    gradient = slope + np.roll(slope_after, 1)
    bend = 0.75 * 0.5 * (step + np.roll(step, 1)) / v**5
    root = sparse.diags(np.sqrt(bend))
    program.add_squares(program.across(square=root), np.sqrt(bend) * v**2, 1.0)
    program.linear[program.part("square")] += gradient
    program.linear[program.part("shift")] += shape.reply.step.T @ (2.0 / total)


def _add_ellipse(program: Program, shape: Shape, speeds: Profile) -> None:
    limits, path, reply = shape.limits, shape.path, shape.reply
    count = program.count
    one, ahead = sparse.identity(count, format="csr"), _ahead(count)
    square, step = speeds.speed**2, path.step
    half = sparse.diags(0.5 / step)
    # a = (b' - b) / (2 step), and its first-order change with the step.
    along_square = half @ (ahead - one)
    along_shift = -sparse.diags(speeds.acceleration / step) @ reply.step
    # Lateral acceleration b k about the last line; its constant part is -b0 times the bend's change: none at 0.
    across_square = sparse.diags(path.curvature)
    across_shift = sparse.diags(square) @ reply.curvature
    program.add_rows(program.across(square=along_square, shift=along_shift), -limits.brake, limits.accel)
    for take in (one, ahead):
        lateral = (take @ (square * path.curvature)) / limits.grip.lateral
        axis = np.where(speeds.acceleration > 0.0, limits.grip.drive, limits.grip.brake)
        angle = np.arctan2(lateral, speeds.acceleration / axis)
        for at in [angle + turn for turn in TANGENTS] + [np.full(count, turn) for turn in RING]:
            c, s = np.cos(at), np.sin(at) / limits.grip.lateral
            c, s = sparse.diags(c / np.where(c > 0.0, limits.grip.drive, limits.grip.brake)), sparse.diags(s)
            rows = program.across(
                square=c @ along_square + s @ take @ across_square, shift=c @ along_shift + s @ take @ across_shift
            )
            program.add_rows(rows, -FREE, 1.0)
