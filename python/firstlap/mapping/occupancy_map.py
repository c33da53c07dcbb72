"""The occupancy map: drawn from scans at known poses, written in map_server's format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.files import check_writable, write_together
from firstlap.common.yaml_text import read_text
from firstlap.mapping.parameters import MapSettings
from firstlap.mapping.poses import transform
from firstlap.mapping.slam import Keyframe
from firstlap.tracks.map_header import parse_ros_map_yaml
from firstlap.tracks.map_image import UNKNOWN_GRAY, free_pixels, occupied_pixels, read_gray
from firstlap.tracks.track import FloatArray

FREE, OCCUPIED, UNKNOWN = 0, 1, 2
GRAY = np.array([254, 0, UNKNOWN_GRAY], dtype=np.uint8)
GAP = 0.02
"""[m^2] Maximum area of an unknown region surrounded by free cells that becomes free."""
MAP_SUFFIXES = (".yaml", ".yml")


@dataclass(frozen=True, eq=False)
class OccupancyMap:
    """cells (rows, columns): FREE, OCCUPIED or UNKNOWN; row 0 is the lowest.

    origin: (x, y, yaw) of the lower left corner in the map's frame [m, rad]. start: pose of base_link at the start of a
    race, if known; (0, 0, 0) in our own maps.
    """

    cells: npt.NDArray[np.uint8]
    resolution: float
    origin: tuple[float, float, float]
    start: tuple[float, float, float] | None = None
    source: str = ""

    def wall_points(self) -> FloatArray:
        """(N, 2) centers of the occupied cells in the map's frame [m]."""
        rows, columns = np.nonzero(self.cells == OCCUPIED)
        centers: FloatArray = (np.column_stack([columns, rows]).astype(np.float64) + 0.5) * self.resolution
        return transform(np.array(self.origin), centers)

    def field(self) -> _core.LikelihoodField:
        """The distance field of the walls, for a localizer. Raises InputError for a map without walls."""
        occupied = np.ascontiguousarray(self.cells == OCCUPIED, dtype=np.uint8)
        try:
            return _core.LikelihoodField(occupied, self.resolution, self.origin)
        except ValueError as error:
            raise InputError(f"{self.source or 'map'}: {error}") from None


def draw_map(
    keyframes: list[Keyframe],
    poses: FloatArray,
    laser: tuple[float, float],
    settings: MapSettings,
    on_progress: Callable[[int], object] = lambda _: None,
) -> OccupancyMap:
    """The map of scans at poses (N, 3). Raises InputError.

    laser: x, y in base_link [m]. on_progress: called with the index of each scan drawn.
    """
    reach, resolution = settings.get("grid.range_use"), settings.get("grid.resolution")
    corners = np.vstack(
        [
            transform(pose, k.points[k.points[:, 2] <= reach][:, :2])
            for k, pose in zip(keyframes, poses, strict=True)
            if len(k.points)
        ]
        + [poses[:, :2]]
    )
    margin = settings.get("grid.margin")
    low = np.floor((corners.min(axis=0) - margin) / resolution) * resolution
    columns, rows = (int(n) for n in np.ceil((corners.max(axis=0) + margin - low) / resolution))
    try:
        grid = _core.OccupancyGrid(low[0], low[1], columns, rows, settings.core)
    except ValueError as error:
        raise InputError(str(error)) from None
    for number, (keyframe, pose) in enumerate(zip(keyframes, poses, strict=True)):
        grid.add(tuple(pose), laser, keyframe.points)
        on_progress(number)
    x, y, yaw = (float(value) for value in poses[0])
    return OccupancyMap(
        without_gaps(grid.cells(), resolution), resolution, (float(low[0]), float(low[1]), 0.0), (x, y, yaw)
    )


def without_gaps(cells: npt.NDArray[np.uint8], resolution: float) -> npt.NDArray[np.uint8]:
    """Cells (rows, columns) in which small unknown regions surrounded by free cells are free.

    Beams without a return are not drawn, so a few cells on long straights remain unknown although a wall there would
    have been detected.
    """
    from scipy import ndimage

    eight = np.ones((3, 3), dtype=np.bool_)
    places, _ = ndimage.label(cells == UNKNOWN, structure=eight)
    walled = np.unique(places[ndimage.binary_dilation(cells == OCCUPIED, structure=eight)])
    small = np.bincount(places.ravel()) * resolution**2 < GAP
    small[walled] = False
    small[0] = False
    return np.where(small[places], np.uint8(FREE), cells)


def write_map(drawn: OccupancyMap, path: str | Path) -> Path:
    """Writes `path` (YAML) and the image next to it (PGM), both or neither. Returns the image's path. Raises
    InputError."""
    path = check_writable(path, MAP_SUFFIXES)
    picture = path.with_suffix(".pgm")
    rows, columns = drawn.cells.shape
    pixels = GRAY[drawn.cells[::-1]].tobytes()
    x, y, yaw = drawn.origin
    lines = [
        f"image: {picture.name}",
        f"resolution: {drawn.resolution:.9g}",
        f"origin: [{x:.9g}, {y:.9g}, {yaw:.9g}]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
        "mode: trinary",
    ]
    if drawn.start is not None:
        lines += [
            "# base_link at the start, x, y, yaw: start line and direction of travel.",
            "starting_positions:",
            f"  - [{', '.join(f'{round(value, 6) + 0.0:g}' for value in drawn.start)}]",
        ]
    write_together(
        {
            picture: b"P5\n# written by firstlap map\n%d %d\n255\n" % (columns, rows) + pixels,
            path: ("\n".join(lines) + "\n").encode(),
        }
    )
    return picture


def read_map(path: str | Path) -> OccupancyMap:
    """Reads any ROS map (YAML and image). Raises InputError."""
    path = Path(path)
    header = parse_ros_map_yaml(read_text(path), str(path))
    gray = read_gray(path.parent / header.image, header.mode)
    cells = np.full(gray.shape, UNKNOWN, dtype=np.uint8)
    cells[free_pixels(gray, header, [])] = FREE
    cells[occupied_pixels(gray, header)] = OCCUPIED
    start = header.starting_positions[0] if header.starting_positions else None
    return OccupancyMap(np.ascontiguousarray(cells[::-1]), header.resolution, header.origin, start, source=str(path))
