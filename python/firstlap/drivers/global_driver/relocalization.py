"""A car that stands and does not know where: it looks along the whole line for the place that the scan fits."""

from __future__ import annotations

import math

import numpy as np

from firstlap import _core
from firstlap.drivers.global_driver.params import GuardParams
from firstlap.tracks.track import FloatArray

APART = 1.5
"""[m] of line from one place to the next; the car is sought within RADIUS and ANGLE of each."""
RADIUS, ANGLE = 1.2, 0.9
STEP, TURN = 0.15, 0.15
"""[m], [rad] of the raster round each place."""
FINE = 0.04
"""[m], [rad] of the raster round the best of all."""
PLACES = 4
"""Looked at in one step."""
BEAMS = 60
STANDING = 0.1
"""[m/s]"""

Pose = tuple[float, float, float]


class Relocalization:
    """Call `look` in each step in which the pose is lost. A round over all places takes a second or so.

    It begins after `guard.search_after` seconds of standing lost, and is made `guard.searches` times at most until
    `rest` is called: a car that fits nowhere stays where it is.
    """

    def __init__(self, params: GuardParams, field: _core.LikelihoodField, points: FloatArray, yaw: FloatArray) -> None:
        """points (N, 2) and yaw (N,) of the line, in the map's frame."""
        self.params, self._field = params, field
        length = float(np.hypot(*np.diff(points, axis=0, append=points[:1]).T).sum())
        count = max(1, math.ceil(length / APART))
        index = np.arange(count) * len(points) // count
        self._places = [(float(points[i, 0]), float(points[i, 1]), float(yaw[i])) for i in index]
        self.rest()

    def rest(self) -> None:
        """The car knows where it is."""
        self._rounds = 0
        self._begin()

    def _begin(self) -> None:
        self._stood, self._next = 0.0, 0
        self._best: tuple[float, Pose] = (0.0, (0.0, 0.0, 0.0))

    def look(self, seen: FloatArray, speed: float, dt: float) -> Pose | None:
        """The pose that the scan fits best, after the last place of a round, where it fits. seen: returns (N, 2)."""
        if not (abs(speed) < STANDING and math.isfinite(dt)) or self._rounds >= self.params.searches:
            self._begin()
            return None
        self._stood += dt
        if self._stood < self.params.search_after or len(seen) < BEAMS // 2:
            return None
        cloud = np.zeros((min(BEAMS, len(seen)), 4))
        cloud[:, :2] = seen[np.arange(len(cloud)) * len(seen) // len(cloud)]
        for place in self._places[self._next : self._next + PLACES]:
            pose, fit = self._field.search(cloud, place, RADIUS, ANGLE, STEP, TURN)
            if fit > self._best[0]:
                self._best = fit, pose
        self._next += PLACES
        return self._end(cloud) if self._next >= len(self._places) else None

    def _end(self, cloud: FloatArray) -> Pose | None:
        pose, fit = self._field.search(cloud, self._best[1], STEP, TURN, FINE, FINE)
        self._rounds += 1
        self._begin()
        return pose if fit >= self.params.search_fit else None
