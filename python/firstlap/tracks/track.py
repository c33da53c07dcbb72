"""A track: walls and a centerline."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypedDict

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
"""Meters in the track's (or map's) frame, x to the right, y up; angles in rad, counterclockwise."""

SIDES = ("left", "right", "obstacle", "scenery")


class TrackArrays(TypedDict):
    """The arrays that the simulator uses, see `Track.to_arrays`."""

    segments: FloatArray
    visible: npt.NDArray[np.uint8]
    solid: npt.NDArray[np.uint8]
    centerline: FloatArray


@dataclass(frozen=True, eq=False)
class Track:
    """A closed race track in meters; index 0 of the centerline is the start and finish line.

    walls: (N, 2) polylines; a closed one repeats its first point.
    sides: one of `SIDES` per wall, seen in the direction of travel.
    visible: per wall, whether the LiDAR detects it. A low wall is solid but not visible.
    solid: per wall, whether touching it is a contact. Scenery is visible but not solid.
    centerline: (M, 2), closed, first point not repeated, about 0.1 m apart, in the direction of travel.
    width_left, width_right: (M,) distance from the centerline to the nearest solid left and right wall.
    """

    name: str
    walls: list[FloatArray]
    sides: list[str]
    visible: list[bool]
    solid: list[bool]
    centerline: FloatArray
    width_left: FloatArray
    width_right: FloatArray
    source: str = ""
    notes: list[str] = field(default_factory=list)

    @cached_property
    def stations(self) -> FloatArray:
        """(M + 1,) distance along the centerline from the start; the last entry is the length of a lap."""
        closed = np.vstack([self.centerline, self.centerline[:1]])
        return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])

    @property
    def length(self) -> float:
        """Length of the centerline in meters."""
        return float(self.stations[-1])

    @property
    def width(self) -> FloatArray:
        """(M,) left plus right width."""
        return self.width_left + self.width_right

    def width_summary(self) -> tuple[float, float, float]:
        """(min, median, max) of the track's width in meters."""
        width = self.width
        return float(width.min()), float(np.median(width)), float(width.max())

    def start_pose(self, offset_s: float = 0.0) -> tuple[float, float, float]:
        """(x, y, yaw) on the centerline, `offset_s` meters after the start line (negative: before it)."""
        closed = np.vstack([self.centerline, self.centerline[:1]])

        def at(s: float) -> FloatArray:
            s %= self.length
            return np.array([np.interp(s, self.stations, closed[:, 0]), np.interp(s, self.stations, closed[:, 1])])

        ahead = at(offset_s + 0.2) - at(offset_s - 0.2)
        x, y = at(offset_s)
        return float(x), float(y), float(np.arctan2(ahead[1], ahead[0]))

    def reversed(self) -> Track:
        """The same track in the opposite direction, with the same start line."""
        swap = {"left": "right", "right": "left"}
        return replace(
            self,
            sides=[swap.get(side, side) for side in self.sides],
            centerline=np.roll(self.centerline[::-1], 1, axis=0),
            width_left=np.roll(self.width_right[::-1], 1),
            width_right=np.roll(self.width_left[::-1], 1),
            notes=[*self.notes, "opposite direction"],
        )

    def started_at(self, index: int) -> Track:
        """The same track with its start line at centerline point `index`."""
        return replace(
            self,
            centerline=np.roll(self.centerline, -index, axis=0),
            width_left=np.roll(self.width_left, -index),
            width_right=np.roll(self.width_right, -index),
        )

    def to_arrays(self) -> TrackArrays:
        """segments (K, 4) [x1, y1, x2, y2], visible and solid (K,) uint8, centerline (M, 2); contiguous."""
        segments = np.vstack([np.hstack([wall[:-1], wall[1:]]) for wall in self.walls])
        counts = [len(wall) - 1 for wall in self.walls]
        return TrackArrays(
            segments=np.ascontiguousarray(segments),
            visible=np.repeat(np.array(self.visible, dtype=np.uint8), counts),
            solid=np.repeat(np.array(self.solid, dtype=np.uint8), counts),
            centerline=np.ascontiguousarray(self.centerline),
        )
