"""The trace of a step of the map-based driver, as arrays in base_link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from firstlap.control.mpc.horizon import ACCEL, COMMAND, VX, S
from firstlap.control.mpc.line_table import ZONES
from firstlap.drivers.global_driver.guard import plan_poses
from firstlap.mapping.poses import between, transform
from firstlap.tracks.track import FloatArray

if TYPE_CHECKING:
    from firstlap.drivers.global_driver.driver import GlobalDriver

NEARBY = 12.0
"""[m] Radius of the map and line around the car."""


def trace_of(driver: GlobalDriver) -> dict[str, Any]:
    """Lengths in meters, in base_link at the controller's estimate.

    result: speed, steering angle, status. ranges, first_beam, beam_step: the scan. estimate: of the filter, None with
    the true pose. pose: on the map, None where lost. map: (N, 2) wall points nearby. line: (M, 2) nearby, line_speed
    (M,). plan: (K, 3) poses, plan_speed (K,), plan_accel and plan_steering (K - 1,), plan_time (K,), line_speed_ahead
    (K,) of the line there, left and right (K,): smallest lateral clearance, including the margin. blocked_at: distance
    to an obstacle in the plan, or None. particles: their number.
    """
    seen, table = driver.seen, driver.controller.table
    scan = seen.get("scan")
    body = driver.controller.body
    result: dict[str, Any] = {
        "result": seen.get("result", (0.0, 0.0, "no_path")),
        "ranges": scan.ranges if scan else np.zeros(0, np.float32),
        "first_beam": scan.angle_min if scan else 0.0,
        "beam_step": scan.angle_increment if scan else 0.0,
        "pose": seen.get("pose"),
        "estimate": driver.estimate.to_dict() if driver.estimate else None,
        "particles": driver.localizer.core.particles,
        "blocked_at": driver.guard.blocked_at,
    }
    nothing = np.zeros((0, 2))
    at = None if body is None else np.array(body[:3])
    line, index = (nothing, np.zeros(0, np.intp)) if at is None else _nearby(table.points, at)
    result["map"] = nothing if at is None else _nearby(driver.prepared.known.wall_points(), at)[0]
    result["line"], result["line_speed"] = line, table.columns[index, 1]
    return {**result, **_plan(driver, at)}


def _plan(driver: GlobalDriver, at: FloatArray | None) -> dict[str, Any]:
    plan, table = driver.controller.plan, driver.controller.table
    if plan is None or at is None:
        names = ("plan_speed", "plan_accel", "plan_steering", "plan_time", "line_speed_ahead", "left", "right")
        return {"plan": np.zeros((0, 3)), **{name: np.zeros(0) for name in names}}
    ahead = table.at(plan.states[S])
    x, y, yaw = (float(value) for value in at)
    poses = plan_poses(plan, table, (x, y, yaw))
    offset = plan.states[1]
    margin = driver.parts.mpc.margin
    return {
        "plan": poses,
        "plan_speed": plan.states[VX].copy(),
        "plan_accel": plan.inputs[ACCEL].copy(),
        "plan_steering": plan.inputs[COMMAND].copy(),
        "plan_time": plan.step * np.arange(len(poses)),
        "line_speed_ahead": driver.parts.mpc.speed_scale * ahead[:, 1],
        "left": ahead[:, 2 : 2 + ZONES].min(axis=1) - offset + margin,
        "right": ahead[:, 2 + ZONES :].min(axis=1) + offset + margin,
    }


def _nearby(points: FloatArray, at: FloatArray) -> tuple[FloatArray, Any]:
    """Points (N, 2) of the map near a pose, in its frame, and their mask."""
    index = np.flatnonzero(np.hypot(*(points - at[:2]).T) < NEARBY)
    return transform(between(at, np.zeros(3)), points[index]), index
