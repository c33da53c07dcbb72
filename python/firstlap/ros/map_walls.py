"""The walls of a nav_msgs/OccupancyGrid as polylines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from firstlap.ros.conversions import yaw_of
from firstlap.tracks.medial import contours
from firstlap.tracks.track import FloatArray

OCCUPIED = 50
"""[%] Occupancy from which a cell is a wall; unknown cells are not."""
MAX_CELLS = 25_000_000
MAX_LINES = 2_000
"""Maximum number of polylines; the longest are kept."""
SMOOTH = 0.4
"""Tolerance of the simplification, in cells."""


def walls_of(grid: Any) -> tuple[FloatArray, ...]:
    """Outlines (N, 2) [m] of the occupied cells in the map frame. Raises ValueError for an invalid message."""
    rows, columns, resolution = int(grid.info.height), int(grid.info.width), float(grid.info.resolution)
    if not (0 < rows * columns <= MAX_CELLS and rows * columns == len(grid.data) and 0.0 < resolution < 10.0):
        raise ValueError(f"a map of {columns} x {rows} cells of {resolution:g} m in {len(grid.data)} bytes")
    cells = np.frombuffer(grid.data, dtype=np.int8).reshape(rows, columns)
    occupied = np.pad((cells >= OCCUPIED).astype(np.float64), 1)
    lines = [np.asarray(shapely.LineString(line).simplify(SMOOTH).coords) for line in contours(occupied, 0.5)]
    lines = sorted(lines, key=len, reverse=True)[:MAX_LINES]
    origin = grid.info.origin
    yaw = yaw_of(origin.orientation)
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, s], [-s, c]])
    corner = np.array([origin.position.x, origin.position.y])
    # A padded cell's center lies half a cell before its index.
    return tuple((line - 0.5) * resolution @ turn + corner for line in lines)
