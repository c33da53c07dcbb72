"""Drawings of the other drivers' perception and decisions, from their traces (cpp/firstlap/drivers,
global_driver/trace.py)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.perception.scan import laser_of, ray_ends
from firstlap.pitwall.frame import Points
from firstlap.pitwall.shapes import (
    NOTHING,
    Segments,
    beam_angles,
    chain,
    column_in,
    found_in,
    joined,
    multiples,
    number_in,
    points_in,
    returns_in,
)

Values = npt.NDArray[np.float64]
NO_VALUES: Values = np.zeros(0)
NO_LINES: Segments = chain(NOTHING, 0.0)
ARC = 3.0
"""[m] Maximum length of drawn arcs."""
EVERY = 5
"""Number of plan stages between two car outlines."""
ABOVE = 0.04
"""[m] Height of lines above the ground: over areas, under points."""


@dataclass(frozen=True)
class Drawing:
    """In base_link [m]. free: boundary of the free space, chosen: its chosen part, right to left around the laser.
    trouble: the most critical returns. wanted: a desired arc that is not free. aim: a ray from the laser. line: racing
    line of the map-based driver. spread: radius of its position uncertainty.
    """

    returns: Points = field(default_factory=lambda: NOTHING)
    free: Points = field(default_factory=lambda: NOTHING)
    chosen: Points = field(default_factory=lambda: NOTHING)
    trouble: Points = field(default_factory=lambda: NOTHING)
    aim: Points = field(default_factory=lambda: NOTHING)
    arc: Points = field(default_factory=lambda: NOTHING)
    wanted: Points = field(default_factory=lambda: NOTHING)
    left: Segments = field(default_factory=lambda: NO_LINES)
    right: Segments = field(default_factory=lambda: NO_LINES)
    known: Points = field(default_factory=lambda: NOTHING)
    line: Points = field(default_factory=lambda: NOTHING)
    plan: Points = field(default_factory=lambda: NOTHING)
    plan_speed: Values = field(default_factory=lambda: NO_VALUES)
    outlines: Segments = field(default_factory=lambda: NO_LINES)
    spread: float = 0.0


def draw(driver: str, trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    """The drawing of a step; only returns for an unknown driver. geometry: of the car file. Never raises for an
    incomplete trace."""
    return _DRAWN.get(driver, _returns_only)(trace, geometry)


def _returns_only(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    return Drawing(returns=np.vstack([_returns(trace, geometry), points_in(trace, "points")]))


def _ends(geometry: Mapping[str, float], angles: Values, ranges: Values) -> Points:
    """(N, 2) endpoints of rays from the laser."""
    return ray_ends(laser_of(geometry), angles, ranges)


def _returns(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Points:
    return returns_in(trace, laser_of(geometry))


def _ray(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Points:
    angle, free = number_in(trace, "aim"), number_in(trace, "aim_free")
    if not math.isfinite(angle + free):
        return NOTHING
    return _ends(geometry, np.array([angle, angle]), np.array([0.0, max(free, 0.3)]))


def _arc(steering_angle: float, length: float, geometry: Mapping[str, float]) -> Points:
    """The rear axle's arc at a steering angle [rad] over a length [m]."""
    if not math.isfinite(steering_angle + length):
        return NOTHING
    s = np.linspace(0.0, min(max(length, 0.1), ARC), 40)
    yaw = math.tan(steering_angle) / geometry["wheelbase"] * s
    return np.column_stack([s * np.sinc(yaw / np.pi), s * np.sinc(0.5 * yaw / np.pi) * np.sin(0.5 * yaw)])


def _gap(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    free = column_in(trace, "free")
    angles = multiples(number_in(trace, "step"), np.arange(len(free), dtype=float) - len(free) // 2)
    run = column_in(trace, "run")
    ends = _ends(geometry, angles, free)
    within = (angles >= run[0] - 1e-9) & (angles <= run[1] + 1e-9) if len(run) == 2 else np.zeros(len(free), bool)
    nearest = column_in(trace, "nearest")
    arc, wanted = number_in(trace, "arc"), number_in(trace, "wanted")
    return Drawing(
        returns=_returns(trace, geometry),
        free=ends,
        chosen=ends[within],
        trouble=nearest.reshape(1, 2) if len(nearest) == 2 and len(free) else NOTHING,
        aim=_ray(trace, geometry) if len(free) else NOTHING,
        arc=_arc(arc, number_in(trace, "arc_free"), geometry) if len(free) else NOTHING,
        wanted=_arc(wanted, 0.5 * ARC, geometry) if len(free) and wanted != arc else NOTHING,
    )


def _disparity(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    extended, ranges = column_in(trace, "extended"), column_in(trace, "ranges")
    angles = beam_angles(trace, len(extended))
    block = column_in(trace, "block").astype(int)
    ends = _ends(geometry, angles, extended)
    corners = column_in(trace, "disparities").astype(int)
    corners = corners[(corners >= 0) & (corners < min(len(ranges), len(angles)))]
    return Drawing(
        returns=_returns(trace, geometry),
        free=ends,
        chosen=ends[block[0] : block[1] + 1] if len(block) == 2 else NOTHING,
        trouble=_ends(geometry, angles[corners], ranges[corners]),
        aim=_ray(trace, geometry) if len(extended) else NOTHING,
    )


def _pid(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    returns = _returns(trace, geometry)
    if not len(returns):
        return Drawing()
    laser = np.array(laser_of(geometry))
    preview, error = number_in(trace, "preview"), number_in(trace, "error")
    ahead = laser + np.array([preview, 0.0])
    command = column_in({"angle": list(trace.get("result", ()))[1:2]}, "angle")
    return Drawing(
        returns=returns,
        left=_wall_of(trace, "left", laser, ahead),
        right=_wall_of(trace, "right", laser, ahead),
        aim=np.vstack([ahead, ahead + np.array([0.0, error])]) if math.isfinite(preview + error) else NOTHING,
        arc=_arc(float(command[0]), number_in(trace, "free"), geometry) if len(command) else NOTHING,
    )


def _wall_of(trace: Mapping[str, Any], side: str, laser: Points, ahead: Points) -> Segments:
    """The wall from two beams, and the distances to it at the laser and at the preview."""
    sign = 1.0 if side == "left" else -1.0
    angle, distance, preview = (number_in(trace, side, name) for name in ("angle", "distance", "preview"))
    if not math.isfinite(angle + distance + preview):
        return NO_LINES
    normal = sign * np.array([-math.sin(sign * angle), math.cos(angle)])
    near, far = laser + normal * distance, ahead + normal * preview
    along = (far - near) / max(float(np.hypot(*(far - near))), 1e-6)
    return joined(np.vstack([near - along, laser, ahead]), np.vstack([far + along, near, far]), ABOVE)


def _global(trace: Mapping[str, Any], geometry: Mapping[str, float]) -> Drawing:
    plan = found_in(trace, ("plan",))
    plan = plan if plan.ndim == 2 and plan.shape[1] == 3 and np.isfinite(plan).all() else np.zeros((0, 3))
    return Drawing(
        returns=_returns(trace, geometry),
        known=points_in(trace, "map"),
        line=points_in(trace, "line"),
        plan=plan[:, :2],
        plan_speed=column_in(trace, "plan_speed"),
        outlines=_outlines(plan[EVERY - 1 :: EVERY], geometry),
        spread=max(3.0 * number_in(trace, "estimate", "std"), 0.02) if trace.get("estimate") else 0.0,
    )


def _outlines(poses: Values, geometry: Mapping[str, float]) -> Segments:
    rear, half = -geometry["rear_overhang"], 0.5 * geometry["width"]
    front = rear + geometry["length"]
    corners = np.array([[rear, -half], [front, -half], [front, half], [rear, half], [rear, -half]])
    pieces = []
    for x, y, yaw in poses:
        c, s = math.cos(yaw), math.sin(yaw)
        pieces.append(chain(corners @ np.array([[c, s], [-s, c]]) + (x, y), ABOVE))
    return np.concatenate(pieces) if pieces else NO_LINES


_DRAWN: dict[str, Callable[[Mapping[str, Any], Mapping[str, float]], Drawing]] = {
    "local": lambda _trace, _geometry: Drawing(),
    "gap": _gap,
    "disparity": _disparity,
    "pid": _pid,
    "global": _global,
}
