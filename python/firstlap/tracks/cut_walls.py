"""Realistic walls: pipes with joints, and sections that are too low for the LiDAR."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from shapely import LineString, Point
from shapely.ops import substring

from firstlap.tracks.track import FloatArray, Track

Pieces = list[tuple[float, bool]]
"""A wall from its beginning to its end as (length in m, whether it is visible to the LiDAR)."""


def with_pipes(track: Track, length: float, joints: Sequence[float]) -> Track:
    """The track with its left and right walls cut into pipes of about `length` m, separated by the joints (m) in turn.

    A joint is invisible to the LiDAR but solid for the car.
    """
    pattern = [piece for joint in joints for piece in ((length, True), (joint, False))]

    def pieces(wall: LineString, side: str) -> Pieces | None:
        return _repeated(pattern, wall.length) if side in ("left", "right") else None

    return _cut(track, pieces)


def with_low_wall(track: Track, side: str, begin: float, end: float, post: float, gap: float) -> Track:
    """The track with the wall on `side` visible only as posts with gaps from station `begin` to `end` (m)."""

    def pieces(wall: LineString, wall_side: str) -> Pieces | None:
        low, high = sorted(wall.project(Point(track.start_pose(at)[:2])) for at in (begin, end))
        if wall_side != side or not 2.0 * gap < high - low < 0.5 * wall.length:
            return None
        posts = _repeated([(gap, False), (post, True)], high - low)
        return [(low, True), *posts, (wall.length - high, True)]

    return _cut(track, pieces)


def with_scenery(track: Track, lines: Sequence[FloatArray]) -> Track:
    """The track with lines outside of it that are visible to the LiDAR but not solid."""
    count = len(lines)
    return replace(
        track,
        walls=[*track.walls, *lines],
        sides=[*track.sides, *["scenery"] * count],
        visible=[*track.visible, *[True] * count],
        solid=[*track.solid, *[False] * count],
    )


def _repeated(pattern: Pieces, total: float) -> Pieces:
    """The pattern repeated over `total` meters, scaled so that it fits a whole number of times."""
    period = sum(length for length, _ in pattern)
    count = max(1, round(total / period))
    return [(length * total / (count * period), seen) for length, seen in pattern * count]


def _cut(track: Track, pieces_of: Callable[[LineString, str], Pieces | None]) -> Track:
    """The track with every visible wall cut into `pieces_of(wall, side)`; None leaves a wall unchanged."""
    walls: list[FloatArray] = []
    sides, visible, solid = [], [], []
    for wall, side, seen, hard in zip(track.walls, track.sides, track.visible, track.solid, strict=True):
        line = LineString(wall)
        pieces = (pieces_of(line, side) if seen else None) or [(line.length, seen)]
        ends = np.cumsum([length for length, _ in pieces])
        ends[-1] = line.length
        for (length, piece_seen), end in zip(pieces, ends, strict=True):
            if length > 1e-6:
                walls.append(np.asarray(substring(line, end - length, end).coords, dtype=np.float64))
                sides.append(side)
                visible.append(piece_seen)
                solid.append(hard)
    return replace(track, walls=walls, sides=sides, visible=visible, solid=solid)
