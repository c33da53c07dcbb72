"""Ground truth: the medial line of a track, its width, and the side of every wall.

It is computed in the same way for all tracks and maps, ours or recorded: the line of all points as far from the left
walls as from the right ones (solid walls, with their joints closed), not smoothed. A wall is left or right by the loop
that it belongs to, relative to the direction of travel.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import shapely
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from firstlap.tracks.medial import distances, left_normals, resample_closed
from firstlap.tracks.track import FloatArray, Track

LEFT, RIGHT, NEITHER, UNKNOWN = 1, -1, 0, 2
"""Sides. NEITHER: an obstacle or scenery. UNKNOWN: no wall nearby, or walls of both sides: not evaluated."""

SPACING = 0.05
WALL_SPACING = 0.02
CLEARLY = 0.05

IntArray = npt.NDArray[np.intp]
SideArray = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """Ground truth of one track in one direction of travel.

    line: (M, 2) closed medial line, about 0.05 m apart [m, map frame]. width: (M,) of the track there [m].
    walls: (K, 2) samples of every wall visible to the LiDAR; sides: (K,) LEFT, RIGHT or NEITHER.
    """

    line: FloatArray
    width: FloatArray
    walls: FloatArray
    sides: SideArray

    @cached_property
    def _tangent(self) -> FloatArray:
        return _unit(np.roll(self.line, -1, axis=0) - self.line)

    @cached_property
    def _line_tree(self) -> cKDTree:
        return cKDTree(self.line)

    @cached_property
    def _wall_trees(self) -> dict[int, cKDTree]:
        return {int(side): cKDTree(self.walls[self.sides == side]) for side in np.unique(self.sides)}

    @classmethod
    def of(cls, track: Track) -> GroundTruth:
        """The ground truth of `track` in its direction of travel."""
        solid = {
            side: [w for w, s, hard in zip(track.walls, track.sides, track.solid, strict=True) if s == side and hard]
            for side in ("left", "right")
        }
        line = _medial(track.centerline, solid["left"], solid["right"])
        samples, sides = [], []
        for wall, side, visible in zip(track.walls, track.sides, track.visible, strict=True):
            if visible:
                points = shapely.get_coordinates(shapely.segmentize(shapely.LineString(wall), WALL_SPACING))
                samples.append(points)
                sides.append(np.full(len(points), {"left": LEFT, "right": RIGHT}.get(side, NEITHER), dtype=np.int8))
        width = distances(line, solid["left"]) + distances(line, solid["right"])
        return cls(line, width, np.vstack(samples), np.concatenate(sides))

    def reversed(self) -> GroundTruth:
        """The ground truth for the opposite direction of travel."""
        swapped = np.where(self.sides == NEITHER, NEITHER, -self.sides).astype(np.int8)
        return GroundTruth(self.line[::-1].copy(), self.width[::-1].copy(), self.walls, swapped)

    def along(self, x: float, y: float, yaw: float) -> float:
        """Cosine of the angle between `yaw` [rad] and the direction of travel at (x, y) [m]."""
        tangent = self._tangent[int(self._line_tree.query((x, y))[1])]
        return float(tangent @ (np.cos(yaw), np.sin(yaw)))

    def station(self, x: float, y: float, yaw: float) -> int:
        """Index into `line` nearest to a car at (x, y) [m] with heading `yaw` [rad], on the part that it drives
        along."""
        near = np.asarray(self._line_tree.query((x, y), k=min(40, len(self.line)))[1])
        along = self._tangent[near] @ (np.cos(yaw), np.sin(yaw))
        return int(near[np.argmax(along > -0.2)])

    def beside(self, points: FloatArray, station: int, behind: float, ahead: FloatArray) -> tuple[FloatArray, IntArray]:
        """(lateral, index): how far left of the medial line each point (N, 2) lies [m], and where along it.

        Only the part from `behind` [m] before to `ahead` (N,) [m] after index `station` is considered: a line that
        leaves the track through a hole is compared with the track that it left.
        """
        first = -int(behind / SPACING)
        offsets = np.arange(first, int(float(np.max(ahead, initial=0.0)) / SPACING) + 1)
        index = (station + offsets) % len(self.line)
        gap = np.hypot(*np.moveaxis(points[:, None, :] - self.line[index][None, :, :], 2, 0))
        gap[offsets[None, :] * SPACING > np.maximum(ahead, SPACING)[:, None]] = np.inf
        nearest = index[np.argmin(gap, axis=1)]
        best = np.full(len(points), np.inf)
        lateral = np.zeros(len(points))
        for start in (nearest - 1, nearest):
            a = self.line[start % len(self.line)]
            ab = self.line[(start + 1) % len(self.line)] - a
            t = np.clip(((points - a) * ab).sum(axis=1) / (ab * ab).sum(axis=1), 0.0, 1.0)
            off = points - a - t[:, None] * ab
            distance = np.hypot(*off.T)
            sign = np.where(ab[:, 0] * off[:, 1] - ab[:, 1] * off[:, 0] >= 0.0, 1.0, -1.0)
            nearer = distance < best
            lateral[nearer] = (sign * distance)[nearer]
            best[nearer] = distance[nearer]
        return lateral, nearest

    def stations_from(self, points: FloatArray, station: int) -> FloatArray:
        """(N,) distance [m] along the medial line from index `station` to each point (N, 2), behind negative."""
        index = np.asarray(self._line_tree.query(points)[1])
        count = len(self.line)
        return np.asarray(((index - station + count // 2) % count - count // 2) * SPACING)

    def side_of(self, points: FloatArray, tolerance: float) -> SideArray:
        """(N,) true side of LiDAR returns (N, 2): that of the wall within `tolerance` [m].

        UNKNOWN if there is none, or if both sides are within it and neither is nearer by 0.05 m: a thin wall
        between two parts of the track.
        """
        found = np.full((len(points), 3), np.inf)
        for column, side in enumerate((LEFT, RIGHT, NEITHER)):
            tree = self._wall_trees.get(side)
            if tree is not None and len(points):
                found[:, column] = tree.query(points, distance_upper_bound=tolerance)[0]
        nearest = np.argmin(found, axis=1)
        first, second, _ = np.sort(found, axis=1).T
        sides = np.array([LEFT, RIGHT, NEITHER], dtype=np.int8)[nearest]
        sides[~(first + CLEARLY <= second) | np.isinf(first)] = UNKNOWN
        return sides


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.hypot(*vectors.T), 1e-12)[:, None])


def _medial(line: FloatArray, left: list[FloatArray], right: list[FloatArray]) -> FloatArray:
    """The track's centerline without smoothing: moved back to equal distances from both sides."""
    for _ in range(3):
        line = resample_closed(line, SPACING)
        for _ in range(4):
            step = 0.5 * np.clip(distances(line, right) - distances(line, left), -0.04, 0.04)
            line = line - gaussian_filter1d(step, 0.7, mode="wrap")[:, None] * left_normals(line)
    return resample_closed(line, SPACING)
