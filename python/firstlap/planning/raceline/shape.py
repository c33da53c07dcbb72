"""Constraints of every optimizer step: the corridor, the maximum curvature, and the trust region."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.params import Limits, LineParams
from firstlap.planning.raceline.path import Path, Response, resampled, response
from firstlap.planning.raceline.quadratic import FREE, Program
from firstlap.tracks.track import FloatArray

WALL_PRICE = 4.0
BEND_PRICE = 1.0
TURN_SHARE = 0.4
"""Maximum shift as a share of the radius of curvature, so that normals never cross."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A path between walls: its response to shifts and its lateral clearance (N, bins) [m] without the margin."""

    path: Path
    reply: Response
    left: FloatArray
    right: FloatArray
    bins: FloatArray
    limits: Limits

    @property
    def cost(self) -> float:
        """Constraint violation of the path [s], in units of the optimizer's slack."""
        short = np.maximum(0.0, -np.minimum(self.left.min(axis=1), self.right.min(axis=1)))
        sharp = np.maximum(0.0, np.abs(self.path.curvature) - self.limits.curvature)
        step = float(self.path.step.mean())
        return step * float(WALL_PRICE * short.sum() + BEND_PRICE * sharp.sum())


def shape_of(points: FloatArray, corridor: Corridor, limits: Limits, params: LineParams) -> Shape:
    """The shape of a path through points (N, 2), resampled."""
    path = resampled(points, params.spacing)
    left, right = corridor.rooms(path.poses, params.margin)
    return Shape(path, response(path), left, right, corridor.bins(params.margin), limits)


def shift(shape: Shape, by: FloatArray) -> FloatArray:
    """Points (N, 2) of the path shifted to the left."""
    return shape.path.points + by[:, None] * shape.path.normal


def constrain(program: Program, shape: Shape, trust: float) -> None:
    """Adds corridor, maximum curvature and trust region [m] for the blocks `shift`, `short` and `sharp`."""
    count = program.count
    one = sparse.identity(count, format="csr")
    for k, x in enumerate(shape.bins):
        moved = one + x * shape.reply.heading
        for room, sign in ((shape.left[:, k], 1.0), (shape.right[:, k], -1.0)):
            near = np.flatnonzero(room < trust * (1.5 + abs(x) * 4.0))
            if len(near):
                rows = program.across(shift=sign * moved[near], short=-one[near])
                program.add_rows(rows, -FREE, room[near])
    now, most = shape.path.curvature, shape.limits.curvature
    bend = shape.reply.curvature
    program.add_rows(program.across(shift=bend, sharp=-one), -FREE, most - now)
    program.add_rows(program.across(shift=bend, sharp=one), -most - now, FREE)
    reach = np.minimum(trust, TURN_SHARE / np.maximum(np.abs(now), 1e-9))
    program.bound("shift", -reach, reach)
    program.bound("short", 0.0, FREE)
    program.bound("sharp", 0.0, FREE)
    step = float(shape.path.step.mean())
    program.linear[program.part("short")] = WALL_PRICE * step
    program.linear[program.part("sharp")] = BEND_PRICE * step
