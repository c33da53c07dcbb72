"""Laps of a car on an unknown track: timed from its poses, at the place where it started."""

from __future__ import annotations

import math

import numpy as np

from firstlap.pitwall.frame import DrivenLap, Pose
from firstlap.pitwall.lap_setup import LapSetup

REACH = 2.5
"""[m] Half length of the line."""
SHORTEST = 10.0
"""[m] Minimum length of a lap."""
MOVES = 0.1
"""[m/s] Speed above which a car drives."""
AT_LINE = 0.5
"""[m] Maximum distance from the line of a standing start."""
GAP = 1.0
"""[s] A longer gap between poses invalidates the lap."""
FASTEST = 30.0
"""[m/s] A motion faster than this, plus JUMP [m], means that the car was carried or its odometry was reset."""
JUMP = 0.5
APART = 0.05
"""[m] Spacing of the points of a lap's line."""
MAX_POINTS = 20_000
MAX_LAPS = 500
"""Number of laps kept, newest first."""


class LapBook:
    """Times laps from a stream of poses. laps: complete ones. lap_setup: takes the current setup. clearance: [m]
    smallest one in this lap; None if unknown.

    The line is where the car started to drive, perpendicular to its heading. A lap ends when the car crosses it in that
    direction (within 90 degrees), after 10 m at the earliest. A gap or a jump invalidates the lap but keeps the line.
    """

    def __init__(self) -> None:
        self.laps: tuple[DrivenLap, ...] = ()
        self.lap_setup = LapSetup()
        self.clearance: float | None = None
        self._done = 0
        self._line: Pose | None = None
        self._last: tuple[float, Pose, float] | None = None
        self._began: float | None = None
        self._standing = False
        self._length = 0.0
        self._points: list[tuple[float, float, float]] = []

    def add(self, time: float, pose: Pose, speed: float) -> None:
        """Adds a pose. time: [s]; a decreasing one means that the clock was reset. speed: [m/s]."""
        before, self._last = self._last, (time, pose, speed)
        if before is None or time == before[0]:
            return
        step = math.hypot(pose[0] - before[1][0], pose[1] - before[1][1])
        passed = time - before[0]
        if not 0.0 < passed <= GAP or step > JUMP + FASTEST * passed:
            self._began = None
            return
        if speed >= MOVES:
            self._start_here(before)
        self._length += step
        crossed = self._crossed(before[1], pose)
        if crossed is not None:
            self._over(before[0] + crossed * passed, (before[1], pose, crossed), speed)
        elif self._began is not None:
            self._note(pose, speed)

    def near(self, clearance: float) -> None:
        """Adds a distance [m] to the nearest wall."""
        self.clearance = clearance if self.clearance is None else min(self.clearance, clearance)

    def _start_here(self, before: tuple[float, Pose, float]) -> None:
        """Starts a standing-start lap if the car starts to move at the line, or if there is no line yet."""
        time, pose, speed = before
        if self._line is None:
            self._line = pose
        elif self._began is not None or speed >= MOVES:
            return
        along, aside, turn = self._at(pose)
        if abs(along) <= AT_LINE and abs(aside) <= REACH and abs(turn) < 0.5 * math.pi:
            self._begin(time, pose, speed, standing=True)

    def _begin(self, time: float, pose: Pose, speed: float, standing: bool) -> None:
        self._began, self._standing, self._length = time, standing, 0.0
        self._points = [(pose[0], pose[1], speed)]
        self.clearance = None
        self.lap_setup.begin()

    def _at(self, pose: Pose) -> tuple[float, float, float]:
        """Relative to the line: [m] beyond it, [m] left of its middle, and heading error [rad]."""
        x, y, yaw = self._line or (0.0, 0.0, 0.0)
        dx, dy, c, s = pose[0] - x, pose[1] - y, math.cos(yaw), math.sin(yaw)
        return dx * c + dy * s, dy * c - dx * s, math.remainder(pose[2] - yaw, 2.0 * math.pi)

    def _crossed(self, before: Pose, pose: Pose) -> float | None:
        """Where the line was crossed between two poses, as a fraction from 0 to 1; None if it was not."""
        if self._line is None or (self._began is not None and self._length < SHORTEST):
            return None
        (along, aside, _), (beyond, then_aside, turn) = self._at(before), self._at(pose)
        if not along < 0.0 <= beyond or abs(turn) >= 0.5 * math.pi:
            return None
        share = along / (along - beyond)
        return share if abs(aside + share * (then_aside - aside)) <= REACH else None

    def _over(self, time: float, between: tuple[Pose, Pose, float], speed: float) -> None:
        before, after, share = between
        x, y = (a + share * (b - a) for a, b in zip(before[:2], after[:2], strict=True))
        if self._began is not None:
            self._done += 1
            table = np.array([*self._points, (x, y, speed)])
            lap = DrivenLap(self._done, time - self._began, table[:, :2], table[:, 2], self.clearance, self._standing)
            self.laps = (*self.laps, self.lap_setup.sign(lap))[-MAX_LAPS:]
        self._begin(time, (x, y, after[2]), speed, standing=False)

    def _note(self, pose: Pose, speed: float) -> None:
        x, y, _ = self._points[-1]
        if math.hypot(pose[0] - x, pose[1] - y) >= APART and len(self._points) < MAX_POINTS:
            self._points.append((pose[0], pose[1], speed))
