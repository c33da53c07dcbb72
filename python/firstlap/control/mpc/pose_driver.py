"""The controller with the simulator's pose, to evaluate the controller alone; not for comparisons."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from time import thread_time

import numpy as np

from firstlap import _core
from firstlap.control.mpc.controller import Controller
from firstlap.control.mpc.observer import wrapped

Pose = tuple[float, float, float]


@dataclass(frozen=True)
class PoseErrors:
    """Standard deviations [m], [rad] and age [s] of the pose given to the controller."""

    place: float = 0.0
    heading: float = 0.0
    age: float = 0.0


class PoseDriver:
    """Gives the controller the true pose with errors. Set `race` before stepping.

    times: CPU time per step of this thread [s].
    """

    def __init__(self, controller: Controller, errors: PoseErrors | None = None, seed: int = 1) -> None:
        self.controller = controller
        self.errors = errors or PoseErrors()
        self.race: _core.Race | None = None
        self.times: list[float] = []
        self._seed = seed
        self.reset()

    def reset(self) -> None:
        """Resets the memory."""
        self.controller.reset()
        self.times = []
        self._random = np.random.default_rng(self._seed)
        self._past: deque[tuple[float, Pose]] = deque(maxlen=64)
        self._time = 0.0

    def step(self, _scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> tuple[float, float, str]:
        """One command, for `_core.CallbackDriver`."""
        pose = self._pose(dt)
        begin = thread_time()
        found = self.controller.step(pose, state, dt, self.errors.age)
        self.times.append(thread_time() - begin)
        return found.speed, found.steering_angle, found.status

    def _pose(self, dt: float) -> Pose | None:
        if self.race is None:
            return None
        self._time += dt
        self._past.append((self._time, self.race.pose))
        x, y, yaw = self._at(self._time - self.errors.age)
        place, heading = self._random.normal(0.0, 1.0, 2), float(self._random.normal())
        return (
            x + self.errors.place * float(place[0]),
            y + self.errors.place * float(place[1]),
            yaw + self.errors.heading * heading,
        )

    def _at(self, time: float) -> Pose:
        after_time, after = self._past[-1]
        for before_time, before in reversed(self._past):
            if before_time <= time:
                span = after_time - before_time
                part = (time - before_time) / span if span > 0.0 else 0.0
                turn = wrapped(after[2] - before[2])
                return (
                    before[0] + part * (after[0] - before[0]),
                    before[1] + part * (after[1] - before[1]),
                    before[2] + part * turn,
                )
            after_time, after = before_time, before
        return after


def worst_errors() -> PoseErrors:
    """Errors of a localizer that just meets its target: 3 cm and 1 degree standard deviation, 20 ms delay."""
    return PoseErrors(0.03, math.radians(1.0), 0.02)
