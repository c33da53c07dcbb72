"""The minimum-time velocity profile of a closed path: forward and backward pass within the friction ellipse.

With b = v^2, a = (b' - b) / (2 step) and grip_x the grip for driving or for braking, the ellipse
(a / grip_x)^2 + (b k / lateral)^2 <= 1 holds at both ends of every step: at every point, for the acceleration before
and after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstlap.planning.raceline.params import Limits
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
    cap = np.minimum(limits.speed**2, limits.grip.lateral / np.maximum(bend, 1e-9))
    start = int(np.argmin(cap))
    cap, bend, ahead = np.roll(cap, -start), np.roll(bend, -start), np.roll(step, -start)
    square = _pass(cap, bend, ahead, (limits.grip.lateral, limits.grip.drive, limits.accel))
    back = _pass(
        _turned(square), _turned(bend), ahead[::-1].copy(), (limits.grip.lateral, limits.grip.brake, limits.brake)
    )
    square = np.roll(_turned(back), start)
    after = np.roll(square, -1)
    return Profile(
        speed=np.sqrt(square),
        acceleration=(after - square) / (2.0 * step),
        time=float(np.sum(2.0 * step / (np.sqrt(square) + np.sqrt(after)))),
    )


def _turned(values: FloatArray) -> FloatArray:
    """The lap in the opposite direction, from the same first point."""
    return np.roll(values[::-1], 1)


def _pass(cap: FloatArray, bend: FloatArray, step: FloatArray, most: tuple[float, float, float]) -> FloatArray:
    """v^2 after one pass in which acceleration is limited by motor and ellipse, from the slowest point.

    most: the ellipse's lateral and longitudinal axis, and the motor's limit.
    """
    ceilings, bends, steps = cap.tolist(), bend.tolist(), step.tolist()
    square = [ceilings[0]]
    count = len(ceilings)
    for i in range(count - 1):
        square.append(_next(square[i], ceilings[i + 1], bends[i], bends[i + 1], steps[i], most))
    return np.array(square)


def _next(
    b: float, ceiling: float, bend: float, bend_after: float, step: float, most: tuple[float, float, float]
) -> float:
    """The largest v^2 at the next point: ellipse at this point, ellipse at the next, motor."""
    lateral, along, motor = most
    used = b * bend / lateral
    here = along * math.sqrt(max(0.0, 1.0 - used * used))
    best = min(ceiling, b + 2.0 * step * min(here, motor))
    # Ellipse at the next point, where speed grows: ((b' - b) / reach)^2 + (b' bend / lateral)^2 <= 1, quadratic in b'.
    reach = 2.0 * step * along
    p = 1.0 / (reach * reach)
    q = (bend_after / lateral) ** 2
    root = p * p * b * b - (p + q) * (p * b * b - 1.0)
    if best > b and root > 0.0:
        best = min(best, max(b, (p * b + math.sqrt(root)) / (p + q)))
    return best
