"""Lateral clearance of the car between the walls, and the distance of its rectangle from them."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from firstlap.config.car_file import Car
from firstlap.tracks.track import FloatArray, Track

GRAIN = 0.02
SIGHT = 1.5
BINS = 6


class Corridor:
    """The solid walls of a track for one car.

    The lateral clearance of a pose is how far the whole car can move along its lateral axis until its side touches a
    wall. It does not use normals of a reference line, which could cross.
    """

    def __init__(self, track: Track, car: Car) -> None:
        body = car.core.values()["geometry"]
        self.half_width = 0.5 * float(body["width"])
        self.rear = -float(body["rear_overhang"])
        self.front = float(body["length"]) + self.rear
        solid = [wall for wall, hard in zip(track.walls, track.solid, strict=True) if hard]
        lines = shapely.multilinestrings([shapely.linestrings(wall) for wall in solid])
        self.walls = lines
        shapely.prepare(self.walls)
        self.grains = shapely.get_coordinates(shapely.segmentize(lines, GRAIN))
        self._tree = cKDTree(self.grains)

    def bins(self, margin: float) -> FloatArray:
        """(BINS,) x in base_link [m] of the center of each part of the car's side, including margins."""
        low, high = self.rear - margin, self.front + margin
        return low + (np.arange(BINS) + 0.5) * (high - low) / BINS

    def rooms(self, poses: FloatArray, margin: float) -> tuple[FloatArray, FloatArray]:
        """(left, right), each (N, BINS) [m]: lateral clearance of each part of the side at poses (N, 3) x, y, yaw.

        The margin is subtracted, so it is negative if a wall is closer. Limited if walls are far away.
        """
        low, high = self.rear - margin, self.front + margin
        reach = float(np.hypot(max(-low, high), SIGHT))
        near = self._tree.query_ball_point(poses[:, :2], reach)
        owner = np.repeat(np.arange(len(poses)), [len(found) for found in near])
        wall = self.grains[np.concatenate([np.asarray(found, dtype=np.intp) for found in near])]
        away = wall - poses[owner, :2]
        c, s = np.cos(poses[owner, 2]), np.sin(poses[owner, 2])
        along, across = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
        cell = (high - low) / BINS
        sides = []
        for offset in (across, -across):
            room = np.full((len(poses), BINS), SIGHT)
            here = (offset > 0.0) & (along > low - GRAIN) & (along < high + GRAIN)
            for shift in (-0.5 * GRAIN, 0.5 * GRAIN):
                index = np.clip(np.floor((along[here] + shift - low) / cell).astype(np.intp), 0, BINS - 1)
                np.minimum.at(room, (owner[here], index), offset[here])
            sides.append(room - self.half_width - margin)
        return sides[0], sides[1]

    def clearance(self, poses: FloatArray) -> FloatArray:
        """(N,) exact distance [m] from the car's rectangle at poses (N, 3) to the nearest solid wall; 0 touches."""
        x = np.array([self.rear, self.front, self.front, self.rear])
        y = np.array([-1.0, -1.0, 1.0, 1.0]) * self.half_width
        c, s = np.cos(poses[:, 2:3]), np.sin(poses[:, 2:3])
        corners = np.stack([poses[:, 0:1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=2)
        return np.asarray(shapely.distance(shapely.polygons(corners), self.walls), dtype=np.float64)
