"""Tracks defined by a line with widths: interpolates the line and computes its walls."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.interpolate import CubicSpline

from firstlap.common.errors import InputError
from firstlap.tracks.medial import left_normals
from firstlap.tracks.track import FloatArray

STEP = 0.05
WALL_TOLERANCE = 0.003
SEAM = 1e-4
SAME = 1e-3
"""[m] Points closer than this are the same point."""
MAX_LENGTH = 5000.0
"""[m] Maximum length of a track."""
WIDTHS = (0.15, 10.0)
"""[m] Allowed width to one side."""


def check_line(points: FloatArray, what: str, where: str) -> None:
    """Raises InputError if points (N, 4 or more), x, y first and widths last, are not a valid line of a track."""
    steps = np.hypot(*(np.roll(points[:, :2], -1, axis=0) - points[:, :2]).T)
    if (steps < SAME).any():
        raise InputError(f"{where}: {what} repeats a point; expected each point once")
    if steps.sum() > MAX_LENGTH:
        raise InputError(f"{where}: {what} is longer than {MAX_LENGTH / 1000:g} km; expected meters")
    if (points[:, -2:] < WIDTHS[0]).any() or (points[:, -2:] > WIDTHS[1]).any():
        raise InputError(f"{where}: {what} has a width outside of {WIDTHS[0]} to {WIDTHS[1]:g} m to a side")


def spline_line(points: FloatArray) -> FloatArray:
    """(M, 4) x, y, width right, width left every 0.05 m on a closed cubic spline through points (N, 4).

    Widths are interpolated linearly along the line, so that a step in width stays a step.
    """
    closed = np.vstack([points, points[:1]])
    knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed[:, :2], axis=0).T))])
    at = np.linspace(0.0, knots[-1], max(16, int(knots[-1] / STEP)), endpoint=False)
    xy = CubicSpline(knots, closed[:, :2], bc_type="periodic")(at)
    return np.column_stack([xy, np.interp(at, knots, closed[:, 2]), np.interp(at, knots, closed[:, 3])])


def corner_line(corners: FloatArray, where: str) -> FloatArray:
    """(M, 4) like `spline_line`, but with straights joined by arcs: corners (N, 5) x, y, radius, right, left.

    A corner of radius 0 must lie on a straight; it only sets the widths there. Raises InputError if two arcs
    are longer than the straight between them allows.
    """
    xy, radius = corners[:, :2], corners[:, 2]
    ahead = np.roll(xy, -1, axis=0) - xy
    run = np.hypot(*ahead.T)
    heading = ahead / run[:, None]
    before = np.roll(heading, 1, axis=0)
    turn = np.arctan2(before[:, 0] * heading[:, 1] - before[:, 1] * heading[:, 0], (before * heading).sum(axis=1))
    if (np.abs(turn) > 3.0).any():
        raise InputError(f"{where}: corner {int(np.argmax(np.abs(turn)))} turns straight back; use two corners")
    cut = radius * np.abs(np.tan(turn / 2.0))
    for i in range(len(xy)):
        if radius[i] == 0.0 and abs(turn[i]) > 0.02:
            raise InputError(
                f"{where}: corner {i} turns {np.degrees(turn[i]):.0f} degrees with radius 0; give a radius"
            )
        j = (i + 1) % len(xy)
        if cut[i] + cut[j] > run[i] + 1e-6:
            raise InputError(
                f"{where}: corners {i} and {j} are {run[i]:.2f} m apart and their arcs need {cut[i] + cut[j]:.2f} m"
            )
    pieces = []
    for i in range(len(xy)):
        j = (i + 1) % len(xy)
        pieces.append(_arc(xy[i], before[i], turn[i], radius[i], cut[i], corners[i, 3:]))
        pieces.append(
            _straight(xy[i] + heading[i] * cut[i], xy[j] - heading[i] * cut[j], corners[i, 3:], corners[j, 3:])
        )
    return np.vstack(pieces)


def _arc(
    corner: FloatArray, before: FloatArray, turn: float, radius: float, cut: float, widths: FloatArray
) -> FloatArray:
    count = int(abs(turn) * radius / STEP)
    angle = np.linspace(0.0, abs(turn), count + 1)[:-1] if count else np.zeros(0)
    side = np.sign(turn) * np.array([-before[1], before[0]])
    xy = corner - before * cut + radius * (np.outer(np.sin(angle), before) + np.outer(1.0 - np.cos(angle), side))
    return np.column_stack([xy, np.tile(widths, (len(angle), 1))])


def _straight(begin: FloatArray, end: FloatArray, widths: FloatArray, widths_end: FloatArray) -> FloatArray:
    part = np.linspace(0.0, 1.0, max(1, int(np.hypot(*(end - begin)) / STEP)), endpoint=False)[:, None]
    return np.hstack([begin + part * (end - begin), widths + part * (widths_end - widths)])


def corridor_walls(line: FloatArray, where: str) -> tuple[FloatArray, FloatArray]:
    """(left, right) closed walls beside a line (M, 4) x, y, width right, width left.

    The walls bound the area swept by a bar along the line, so a wall on the inside of a tight corner does not
    cross itself. Raises InputError if the swept area is not a simple ring.
    """
    xy, normal = line[:, :2], left_normals(line[:, :2])
    bar = np.stack([xy - normal * line[:, 2:3], xy + normal * line[:, 3:4]], axis=1)
    corners = np.concatenate([bar, np.roll(bar, -1, axis=0)], axis=1)
    bars = shapely.union_all(shapely.convex_hull(shapely.multipoints(corners)))
    swept = bars.buffer(SEAM, join_style="mitre").buffer(-SEAM, join_style="mitre")
    if not isinstance(swept, shapely.Polygon):
        raise InputError(f"{where}: the walls cut the track; it overlaps itself or is too wide for its corners")
    holes = [ring for ring in swept.interiors if shapely.Polygon(ring).area > 0.003]
    if len(holes) != 1:
        raise InputError(
            f"{where}: the walls leave {len(holes)} islands; expected 1: "
            "the track crosses or overlaps itself, or is too wide for its corners"
        )
    ring = shapely.Polygon(swept.exterior, holes).simplify(WALL_TOLERANCE, preserve_topology=True)
    inner = np.asarray(ring.interiors[0].coords, dtype=np.float64)
    outer = np.asarray(ring.exterior.coords, dtype=np.float64)
    _check_no_short_cut(line, swept, where)
    counter_clockwise = np.sum(xy[:, 0] * np.roll(xy[:, 1], -1) - xy[:, 1] * np.roll(xy[:, 0], -1)) > 0
    return (inner, outer) if counter_clockwise else (outer, inner)


def _check_no_short_cut(line: FloatArray, swept: shapely.Polygon, where: str) -> None:
    """Raises InputError if two parts of the track overlap without a wall between them, found by comparing areas."""
    xy = line[:, :2]
    step = np.hypot(*(np.roll(xy, -1, axis=0) - xy).T)
    drawn = float(np.sum(step * (line[:, 2] + line[:, 3])))
    if swept.area < 0.93 * drawn:
        raise InputError(f"{where}: the track overlaps itself or is too wide for its corners")
