"""Makes a Track from walls: centerline, widths and start line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from firstlap.common.errors import InputError
from firstlap.tracks.medial import curvature, distances, medial_line
from firstlap.tracks.track import FloatArray, Track

CAR_WIDTH = 0.31
MIN_WIDTH = 0.4
MAX_STRAIGHT_CURVATURE = 0.08


def assemble(
    name: str,
    left: list[FloatArray],
    right: list[FloatArray],
    obstacles: list[FloatArray],
    *,
    source: str,
    start: tuple[float, float, float | None] | None = None,
    notes: list[str] | None = None,
) -> Track:
    """A Track from complete closed walls; left and right are relative to the direction of travel.

    start: (x, y, yaw), projected onto the centerline; a yaw against the direction of travel reverses the track.
    Without a start, the start line is on the longest straight.
    Raises InputError if the walls do not form a ring or the car does not fit.
    """
    line = medial_line(left, right, source)
    walls = [*left, *right, *obstacles]
    track = Track(
        name=name,
        walls=walls,
        sides=["left"] * len(left) + ["right"] * len(right) + ["obstacle"] * len(obstacles),
        visible=[True] * len(walls),
        solid=[True] * len(walls),
        centerline=line,
        width_left=distances(line, left),
        width_right=distances(line, right),
        source=source,
        notes=list(notes or []),
    )
    narrowest = track.width_summary()[0]
    if narrowest < MIN_WIDTH:
        raise InputError(
            f"{source}: the track is {narrowest:.2f} m wide at its narrowest; "
            f"the car is {CAR_WIDTH} m wide and needs at least {MIN_WIDTH} m"
        )
    if start is None:
        return track.started_at(straight_start(track))
    track = track.started_at(int(np.argmin(np.hypot(*(track.centerline - start[:2]).T))))
    backwards = start[2] is not None and np.cos(start[2] - track.start_pose()[2]) < 0
    return replace(track.reversed(), notes=track.notes) if backwards else track


def straight_start(track: Track) -> int:
    """Index of a centerline point near the beginning of the longest straight without obstacles."""
    curvatures = np.abs(gaussian_filter1d(curvature(track.centerline), 3.0, mode="wrap"))
    straight = curvatures < MAX_STRAIGHT_CURVATURE
    obstacles = [wall for wall, side in zip(track.walls, track.sides, strict=True) if side == "obstacle"]
    if obstacles:
        straight &= distances(track.centerline, obstacles) > 0.6
    if not straight.any() or straight.all():
        return int(np.argmin(curvatures))
    first = int(np.argmin(straight))
    runs = np.roll(straight, -first)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], runs.astype(np.int8), [0]])))
    begins, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - begins))
    into = min(10, int(ends[longest] - begins[longest]) // 4)
    return int((begins[longest] + into + first) % len(curvatures))
