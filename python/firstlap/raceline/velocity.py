"""The fastest speeds along a given closed path: a forward and a backward pass inside the friction ellipse.

With b = v^2 and a = (b' - b) / (2 step), the ellipse (a / grip_x)^2 + (b k / grip_y)^2 <= 1 holds at both ends of
every step, so it holds at every point for the acceleration before and after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstlap.raceline.params import Limits
from firstlap.tracks.track import FloatArray


@dataclass(frozen=True, eq=False)
class Profile:
    """speed (N,) [m/s] at each point; acceleration (N,) [m/s^2] from each point to the next; time [s] of a lap."""

    speed: FloatArray
    acceleration: FloatArray
    time: float


def profile(curvature: FloatArray, step: FloatArray, limits: Limits) -> Profile:
    """The fastest flying lap on a closed path: curvature (N,) [1/m], step (N,) [m] from each point to the next."""
    bend = np.abs(curvature)
    cap = np.minimum(limits.speed**2, limits.grip_y / np.maximum(bend, 1e-9))
    start = int(np.argmin(cap))
    cap, bend, ahead = np.roll(cap, -start), np.roll(bend, -start), np.roll(step, -start)
    square = _pass(cap, bend, ahead, limits, limits.accel)
    back = _pass(_turned(square), _turned(bend), ahead[::-1].copy(), limits, limits.brake)
    square = np.roll(_turned(back), start)
    after = np.roll(square, -1)
    return Profile(
        speed=np.sqrt(square),
        acceleration=(after - square) / (2.0 * step),
        time=float(np.sum(2.0 * step / (np.sqrt(square) + np.sqrt(after)))),
    )


def _turned(values: FloatArray) -> FloatArray:
    """The lap driven backwards, from the same first point."""
    return np.roll(values[::-1], 1)


def _pass(cap: FloatArray, bend: FloatArray, step: FloatArray, limits: Limits, motor: float) -> FloatArray:
    """v^2 after one pass in which speed may only grow as fast as motor and ellipse allow, from the slowest point."""
    ceilings, bends, steps = cap.tolist(), bend.tolist(), step.tolist()
    square = [ceilings[0]]
    count = len(ceilings)
    for i in range(count - 1):
        square.append(_next(square[i], ceilings[i + 1], bends[i], bends[i + 1], steps[i], limits, motor))
    return np.array(square)


def _next(b: float, ceiling: float, bend: float, bend_after: float, step: float, limits: Limits, motor: float) -> float:
    """The largest v^2 at the next point: ellipse at this point, ellipse at the next, motor."""
    used = b * bend / limits.grip_y
    here = limits.grip_x * math.sqrt(max(0.0, 1.0 - used * used))
    best = min(ceiling, b + 2.0 * step * min(here, motor))
    # Ellipse at the next point: ((b' - b) / reach)^2 + (b' bend / grip_y)^2 <= 1, quadratic in b'.
    reach = 2.0 * step * limits.grip_x
    p = 1.0 / (reach * reach)
    q = (bend_after / limits.grip_y) ** 2
    root = p * p * b * b - (p + q) * (p * b * b - 1.0)
    if root > 0.0:
        best = min(best, (p * b + math.sqrt(root)) / (p + q))
    return best
