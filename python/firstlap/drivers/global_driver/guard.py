"""The guard: braking limits, and whether the planned path is free in the scan."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.control.mpc.horizon import COURSE, OFFSET, Plan, S
from firstlap.control.mpc.line_table import LineTable
from firstlap.control.mpc.model import Model
from firstlap.drivers.global_driver.params import GuardParams
from firstlap.perception.scan import laser_of, ray_ends
from firstlap.tracks.track import FloatArray

CRAWL = 0.3
"""[m/s] Speed below which a stopping car is commanded to 0."""
EVERY = 0.25
"""[m] Spacing of the checked poses: less than the car's length, so that no thin object is missed between them."""
URGENT = 0.5
"""Share of the available braking above which the car begins to brake for an obstacle."""
ACTING, SPARE = 0.15, 0.5
"""Delay [s] until a command acts, in addition to the scans for confirmation; and safety distance [m]."""
HURRY = 1.2
"""Factor on the required braking, because the command acts late."""


def plan_poses(plan: Plan, table: LineTable, origin: tuple[float, float, float]) -> FloatArray:
    """(N + 1, 3) poses of base_link along a plan, relative to a pose in the frame of the line."""
    return _poses(plan.states[S], plan.states[OFFSET], plan.states[COURSE], table, origin)


def way_ahead(plan: Plan, table: LineTable, origin: tuple[float, float, float], length: float) -> FloatArray:
    """(K, 3) the same every EVERY meters, extended parallel to the line until `length` [m] from the plan's
    beginning."""
    states = plan.states
    begin, end = (float(states[S, k]) for k in (0, -1))
    s = np.arange(begin, max(end, begin + length), EVERY)
    offset = np.interp(s, states[S], states[OFFSET])
    return _poses(s, offset, np.interp(s, states[S], states[COURSE], right=0.0), table, origin)


def _poses(
    s: FloatArray, offset: FloatArray, course: FloatArray, table: LineTable, origin: tuple[float, float, float]
) -> FloatArray:
    place = s / table.spacing
    index = np.floor(place).astype(np.intp)
    i = index % len(table.points)
    part = (place - index) * table.spacing
    heading = table.heading[i] + part * table.curvature[i]
    middle = table.heading[i] + 0.5 * part * table.curvature[i]
    x = table.points[i, 0] + part * np.cos(middle) - offset * np.sin(heading) - origin[0]
    y = table.points[i, 1] + part * np.sin(middle) + offset * np.cos(heading) - origin[1]
    cosine, sine = math.cos(origin[2]), math.sin(origin[2])
    return np.column_stack([cosine * x + sine * y, cosine * y - sine * x, heading + course - origin[2]])


@dataclass(frozen=True)
class Body:
    """The car's rectangle and its LiDAR in base_link [m]."""

    rear: float
    front: float
    half_width: float
    laser: tuple[float, float]

    @classmethod
    def of(cls, car: Car) -> Body:
        """Of a car."""
        g = car.core.values()["geometry"]
        rear = -float(g["rear_overhang"])
        return cls(rear, rear + float(g["length"]), 0.5 * float(g["width"]), laser_of(g))


def returns(scan: _core.LaserScan, speed: float, yaw_rate: float, body: Body, reach: float) -> FloatArray:
    """(N, 2) returns nearer than `reach` [m] in base_link at the end of the sweep, deskewed."""
    ranges = scan.ranges
    index = np.flatnonzero(scan.returns() & (ranges < reach))
    distance = ranges[index].astype(np.float64)
    angle = scan.angle_min + scan.angle_increment * index
    before = scan.time_increment * (len(ranges) - 1 - index)
    turn = -yaw_rate * before
    x, y = ray_ends(body.laser, angle, distance).T
    c, s = np.cos(turn), np.sin(turn)
    back = speed * before
    return np.column_stack([c * x - s * y - back * np.cos(0.5 * turn), s * x + c * y - back * np.sin(0.5 * turn)])


class Guard:
    """Checks the plan for returns that block it."""

    def __init__(self, params: GuardParams, car: Car, model: Model) -> None:
        self.params, self.model, self.body = params, model, Body.of(car)
        self.reset()

    def reset(self) -> None:
        """Discards earlier scans."""
        self._seen = 0
        self.blocked_at: float | None = None
        self.braking: float | None = None

    def look(self, poses: FloatArray, points: FloatArray) -> float | None:
        """Distance [m] along `poses` (N, 3) to the first one blocked by returns (M, 2); None if all are free.

        Only obstacles in several consecutive scans count.
        """
        found = self._first(poses, points)
        self._seen = self._seen + 1 if found is not None else 0
        self.blocked_at = found if self._seen >= self.params.blocked_scans else None
        return self.blocked_at

    def _first(self, poses: FloatArray, points: FloatArray) -> float | None:
        if not len(points):
            return None
        body, shrink = self.body, self.params.shrink
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        dx, dy = points[:, 0] - poses[:, :1], points[:, 1] - poses[:, 1:2]
        along, across = c * dx + s * dy, c * dy - s * dx
        way = np.hypot(*poses[0, :2]) + np.append(0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T)))
        inside = (along > body.rear + shrink) & (along < body.front - shrink)
        inside &= np.abs(across) < body.half_width - shrink - self.params.doubt * way[:, None]
        hit = np.flatnonzero(inside.sum(axis=1) >= self.params.blocking)
        if not len(hit):
            return None
        # Between two poses the front reaches the nearest of them.
        i = int(hit[0])
        deep = body.front - shrink - float(along[i][inside[i]].min())
        return max(float(way[i]) - deep, float(way[i - 1]) if i else 0.0)

    def reach(self, speed: float) -> float:
        """Distance [m] that must be free for stopping, including the delay of the command."""
        return self.params.gap + SPARE + speed * ACTING + HURRY * 0.5 * speed * speed / self.most_brake(speed, 0.0)

    def most_brake(self, speed: float, yaw_rate: float) -> float:
        """Braking [m/s^2] that the tires have left while cornering."""
        grip, use = self.model.grip, self.params.brake_use
        cornering = min(1.0, abs(speed * yaw_rate) / grip.lateral)
        left = math.sqrt(max(0.05, 1.0 - cornering * cornering))
        return min(self.model.most_brake, grip.brake) * use * left

    def stopping(self, speed: float, yaw_rate: float) -> float:
        """The speed command that stops the car as fast as the tires allow. speed: when it acts."""
        return self._braking(speed, self.most_brake(speed, yaw_rate))

    def _braking(self, speed: float, brake: float) -> float:
        command = speed - brake / self.model.gain_down
        return command if command > CRAWL else 0.0

    def before_block(self, speed: float, way: float, yaw_rate: float, wanted: float) -> tuple[float, bool]:
        """The speed command with an obstacle ahead, and whether the obstacle limits it.

        speed: when the command acts, `way` [m] from here. Sets `braking` for the next plan.
        """
        self.braking = None
        if self.blocked_at is None:
            return wanted, False
        room = self.blocked_at - self.params.gap - way
        most = self.most_brake(speed, yaw_rate)
        need = speed * speed / (2.0 * room) if room > 0.0 else most
        if need < URGENT * most:
            # A slow car may still creep forward, never faster than it can stop.
            return min(wanted, math.sqrt(2.0 * URGENT * most * room)), wanted > math.sqrt(2.0 * URGENT * most * room)
        self.braking = min(HURRY * need, most)
        return min(wanted, self._braking(speed, self.braking)), True
