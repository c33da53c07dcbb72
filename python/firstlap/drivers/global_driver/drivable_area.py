"""What of a map is the road: the free place that the mapping lap led through, closed where only the laser can pass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from firstlap.mapping.occupancy_map import FREE, UNKNOWN, OccupancyMap
from firstlap.mapping.poses import between, transform
from firstlap.tracks.track import FloatArray

WIDEST, NARROWEST = 0.35, 0.16
"""[m] radius of the disk that finds the road: gaps narrower than twice this are closed."""
SHARE = 0.8
"""Of the least room round the way driven: the disk passes wherever the car did."""
CORNER = 0.45
"""Of the radius: what the disk leaves out of a corner is given back."""


def road_of(known: OccupancyMap, way: FloatArray) -> OccupancyMap:
    """The map with everything unknown but the road and its walls. way: (N, 2) places where base_link was.

    Through the joints of a wall the laser sees what lies behind, which looks as free as the road.
    """
    free = known.cells == FREE
    room = ndimage.distance_transform_edt(free) * known.resolution
    rows, columns = _cells(known, way)
    radius = float(np.clip(SHARE * room[rows, columns].min(), NARROWEST, WIDEST))
    core = _joined(room > radius, rows, columns)
    road = free & _near(core, radius, known.resolution)
    road = free & _near(road, CORNER * radius, known.resolution)
    return replace(known, cells=np.where(free & ~road, np.uint8(UNKNOWN), known.cells))


def _cells(known: OccupancyMap, points: FloatArray) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Rows and columns of points (N, 2) of the map's frame."""
    local = transform(between(np.array(known.origin), np.zeros(3)), points)
    index = np.floor(local / known.resolution).astype(np.intp)
    high = np.array(known.cells.shape[::-1]) - 1
    columns, rows = np.clip(index, 0, high).T
    return rows, columns


def _joined(
    inside: npt.NDArray[np.bool_], rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp]
) -> npt.NDArray[np.bool_]:
    """The part of a place that most of the given cells lie in."""
    parts, _ = ndimage.label(inside)
    count = np.bincount(parts[rows, columns], minlength=2)
    count[0] = 0
    return np.asarray(parts == int(np.argmax(count))) & inside


def _near(place: npt.NDArray[np.bool_], distance: float, resolution: float) -> npt.NDArray[np.bool_]:
    return np.asarray(ndimage.distance_transform_edt(~place) * resolution <= distance)
