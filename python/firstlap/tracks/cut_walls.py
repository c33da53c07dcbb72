"""Walls as they are laid on the floor: pipes with joints, and stretches that the LiDAR sees over."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from shapely import LineString, Point
from shapely.ops import substring

from firstlap.tracks.track import FloatArray, Track

Pieces = list[tuple[float, bool]]
"""A wall from its beginning to its end as (length in m, whether the LiDAR sees it)."""


def with_pipes(track: Track, length: float, joints: Sequence[float]) -> Track:
    """Every left and right wall cut into pipes of about `length` m, with the joints (m) in turn between.

    The beam passes a joint, the car does not: a joint stays solid, because beyond it there is no track.
    """
    pattern = [piece for joint in joints for piece in ((length, True), (joint, False))]

    def pieces(wall: LineString, side: str) -> Pieces | None:
        return _repeated(pattern, wall.length) if side in ("left", "right") else None

    return _cut(track, pieces)


def with_low_wall(track: Track, side: str, begin: float, end: float, post: float, gap: float) -> Track:
    """The wall on `side`, from station `begin` to `end` (m), seen only as posts with gaps between."""

    def pieces(wall: LineString, wall_side: str) -> Pieces | None:
        low, high = sorted(wall.project(Point(track.start_pose(at)[:2])) for at in (begin, end))
        if wall_side != side or not 2.0 * gap < high - low < 0.5 * wall.length:
            return None
        posts = _repeated([(gap, False), (post, True)], high - low)
        return [(low, True), *posts, (wall.length - high, True)]

    return _cut(track, pieces)


def with_scenery(track: Track, lines: Sequence[FloatArray]) -> Track:
    """The track with things outside of it that the LiDAR sees and the car never touches."""
    count = len(lines)
    return replace(
        track,
        walls=[*track.walls, *lines],
        sides=[*track.sides, *["scenery"] * count],
        visible=[*track.visible, *[True] * count],
        solid=[*track.solid, *[False] * count],
    )


def _repeated(pattern: Pieces, total: float) -> Pieces:
    """The pattern over `total` meters, its parts stretched alike so that it comes out even."""
    period = sum(length for length, _ in pattern)
    count = max(1, round(total / period))
    return [(length * total / (count * period), seen) for length, seen in pattern * count]


def _cut(track: Track, pieces_of: Callable[[LineString, str], Pieces | None]) -> Track:
    """The track with every visible wall cut as `pieces_of` says; None leaves a wall as it is."""
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
