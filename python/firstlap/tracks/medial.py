"""The medial line between the left and the right walls, for all kinds of tracks."""

from __future__ import annotations

from typing import cast

import contourpy
import numpy as np
import numpy.typing as npt
import shapely
from scipy.ndimage import distance_transform_edt, gaussian_filter1d

from firstlap.common.errors import InputError
from firstlap.tracks.track import FloatArray

SPACING = 0.1
SMOOTHING = 0.2
MAX_CELLS = 6_000_000


def resample_closed(points: FloatArray, spacing: float) -> FloatArray:
    """A closed line (N, 2), first point not repeated, resampled evenly at about `spacing` meters."""
    closed = np.vstack([points, points[:1]])
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.linspace(0.0, s[-1], max(8, round(float(s[-1]) / spacing)), endpoint=False)
    return np.column_stack([np.interp(at, s, closed[:, 0]), np.interp(at, s, closed[:, 1])])


def contours(grid: FloatArray, level: float) -> list[FloatArray]:
    """Contour lines (N, 2) x, y in grid units of `grid` (rows, columns) at the level."""
    lines = cast(list[FloatArray], contourpy.contour_generator(z=grid).lines(level))
    return [line for line in lines if len(line) > 3]


def is_closed(line: FloatArray) -> bool:
    """Whether a line ends at its first point."""
    return bool(np.allclose(line[0], line[-1]))


def left_normals(points: FloatArray) -> FloatArray:
    """Unit normals (N, 2) pointing left of a closed line's direction."""
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.maximum(np.hypot(*tangent.T), 1e-12)[:, None]
    return np.column_stack([-tangent[:, 1], tangent[:, 0]])


def curvature(points: FloatArray) -> FloatArray:
    """(N,) signed curvature in 1/m of a closed, evenly spaced line; positive turns left."""
    ahead = np.roll(points, -1, axis=0) - points
    behind = np.roll(ahead, 1, axis=0)
    turn = np.arctan2(behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1))
    return np.asarray(turn / np.maximum(0.5 * (np.hypot(*ahead.T) + np.hypot(*behind.T)), 1e-9))


def distances(points: FloatArray, walls: list[FloatArray]) -> FloatArray:
    """(N,) exact distance from each point to the nearest of the wall polylines."""
    lines = shapely.multilinestrings([shapely.linestrings(wall) for wall in walls])
    shapely.prepare(lines)
    return np.asarray(shapely.distance(shapely.points(points), lines), dtype=np.float64)


def signed_area(points: FloatArray) -> float:
    """Area in m^2 of a closed line, positive if it is counterclockwise."""
    x, y = points.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def medial_line(left: list[FloatArray], right: list[FloatArray], where: str) -> FloatArray:
    """Closed line (M, 2), points 0.1 m apart, between the `left` and `right` walls and equally far from both.

    left, right: closed polylines (first point repeated), without joints, relative to the direction of the line.
    Raises InputError if they do not form a ring.
    """
    line = _zero_level(left, right, where)
    for _ in range(3):
        line = resample_closed(line, SPACING)
        for _ in range(3):
            line = _toward_middle(line, left, right)
    sigma = SMOOTHING / SPACING
    while sigma > 0.1:
        smooth = resample_closed(gaussian_filter1d(line, sigma, axis=0, mode="wrap"), SPACING)
        if shapely.LinearRing(smooth).is_simple:
            return smooth
        sigma *= 0.7
    raise InputError(f"{where}: the line between the left and right walls crosses itself; expected one simple loop")


def _toward_middle(line: FloatArray, left: list[FloatArray], right: list[FloatArray]) -> FloatArray:
    """One Newton step along the normal; exact between parallel walls, where the difference has slope 2."""
    step = 0.5 * np.clip(distances(line, right) - distances(line, left), -0.06, 0.06)
    return line - gaussian_filter1d(step, 0.7, mode="wrap")[:, None] * left_normals(line)


def _zero_level(left: list[FloatArray], right: list[FloatArray], where: str) -> FloatArray:
    everything = np.vstack(left + right)
    low = everything.min(axis=0) - 0.2
    size = everything.max(axis=0) + 0.2 - low
    cell = max(0.04, float(np.sqrt(size[0] * size[1] / MAX_CELLS)))
    shape = (int(size[1] / cell) + 2, int(size[0] / cell) + 2)
    if shape[0] * shape[1] > 2 * MAX_CELLS:
        raise InputError(f"{where}: {size[0]:.0f} x {size[1]:.0f} m is too large for a track")
    difference = _grid_distance(right, low, cell, shape) - _grid_distance(left, low, cell, shape)
    loops = [loop[:-1] * cell + low for loop in contours(difference, 0.0) if is_closed(loop) and len(loop) > 8]
    for island, sign in ((left, 1.0), (right, -1.0)):
        starts = shapely.points(np.array([wall[0] for wall in island]))
        around = [loop for loop in loops if bool(shapely.contains(shapely.Polygon(loop), starts).all())]
        if around:
            best: FloatArray = max(around, key=lambda loop: float(shapely.LinearRing(loop).length))
            return best if signed_area(best) * sign > 0 else best[::-1]
    raise InputError(f"{where}: no closed loop between the left and the right walls")


def _grid_distance(walls: list[FloatArray], low: FloatArray, cell: float, shape: tuple[int, int]) -> FloatArray:
    """Distance in meters from every grid point to the nearest wall, to about half a cell."""
    empty: npt.NDArray[np.bool_] = np.ones(shape, dtype=np.bool_)
    for wall in walls:
        line = shapely.segmentize(shapely.LineString(wall), 0.5 * cell)
        column, row = np.rint((shapely.get_coordinates(line) - low) / cell).astype(np.intp).T
        empty[row, column] = False
    return np.asarray(distance_transform_edt(empty, sampling=cell), dtype=np.float64)
