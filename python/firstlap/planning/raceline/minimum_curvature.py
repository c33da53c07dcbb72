"""The minimum-curvature line: a sequence of quadratic programs, each linearized about the last line.

Heilmeier et al., "Minimum curvature trajectory planning and control for an autonomous race car", Vehicle System
Dynamics 58(10), 2020, with the last line as the next reference instead of one fixed reference line.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.params import Limits, LineParams
from firstlap.planning.raceline.quadratic import Program
from firstlap.planning.raceline.shape import Shape, constrain, shape_of, shift
from firstlap.tracks.track import FloatArray

FIRST_TRUST = 0.3
ENOUGH = 0.003
CALM = 1e-3


def minimum_curvature(
    points: FloatArray, corridor: Corridor, limits: Limits, params: LineParams, tell: Callable[[float], None]
) -> FloatArray:
    """Points (N, 2) of the minimum-curvature line between the walls, from a closed initial guess (M, 2).

    tell: called with the progress after each step.
    """
    shape = shape_of(points, corridor, limits, params)
    trust = FIRST_TRUST
    for number in range(params.curvature_rounds):
        tell(number / params.curvature_rounds)
        by = _step(shape, trust)
        if by is None:
            trust *= 0.5
            continue
        trial = shape_of(shift(shape, by), corridor, limits, params)
        better = _cost(shape) - _cost(trial)
        if better > 0.0:
            shape = trial
        trust *= 1.2 if better > 0.0 else 0.5
        trust = min(trust, 2.0 * FIRST_TRUST)
        if trust < ENOUGH or 0.0 < better < CALM * _cost(shape):
            break
    return shape.path.points


def _cost(shape: Shape) -> float:
    return 0.5 * float(np.sum(shape.path.curvature**2 * shape.path.step)) + shape.cost


def _step(shape: Shape, trust: float) -> FloatArray | None:
    """The shift (N,) [m] that minimizes the linearized curvature."""
    count = len(shape.path.points)
    program = Program(count, ("shift", "short", "sharp"))
    constrain(program, shape, trust)
    step = float(shape.path.step.mean())
    program.add_squares(program.across(shift=shape.reply.curvature), -shape.path.curvature, step)
    program.add_squares(program.across(shift=sparse.identity(count)), np.zeros(count), 1e-6)
    for block in ("short", "sharp"):
        program.add_squares(program.across(**{block: sparse.identity(count)}), np.zeros(count), 1e-3)
    solved = program.solve()
    return None if solved is None else solved["shift"]
