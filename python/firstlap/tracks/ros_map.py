"""Reads a ROS occupancy map (YAML and image) as a race track."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import shapely

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import read_text
from firstlap.tracks.assemble import CAR_WIDTH, assemble
from firstlap.tracks.map_header import MapHeader, parse_ros_map_yaml
from firstlap.tracks.map_image import (
    LIKELY_FREE,
    between_share,
    free_pixels,
    occupied_pixels,
    read_gray,
    transparent_share,
)
from firstlap.tracks.map_region import (
    AS_LONG,
    Loop,
    Mask,
    best_loop,
    drivable_regions,
    loops_of,
    refuse_noise,
    region_walls,
    solid_pixels,
    without_islands_of_smear,
    without_smear,
    without_specks,
)
from firstlap.tracks.track import FloatArray, Track

__all__ = ["load_ros_map", "parse_ros_map_yaml"]

RADII = (0.2, 0.16)
MIN_RESOLUTION = 0.02
COMFORTABLE_PIXELS = 4_000_000
MAX_WORKING_PIXELS = 20_000_000
MANY_PIXELS, MANY_LEVELS = 0.02, 16
"""Share of an image's pixels, and number of gray levels, above which they are reported as a possible cause."""


class Grid:
    """Free and occupied pixels, row 0 at the bottom, and their position in the map's frame. Others are unknown."""

    def __init__(self, free: Mask, occupied: Mask, resolution: float, origin: tuple[float, float, float]) -> None:
        self.free, self.occupied, self.resolution, self.origin = free, occupied, resolution, origin
        self.corner = np.zeros(2)

    def crop(self) -> None:
        """Crops the image to the free pixels or to the walls, whichever is smaller, plus a margin."""
        boxes = [_box(self.free), _box(~self.free)]
        rows, columns = min(boxes, key=lambda box: (box[0].stop - box[0].start) * (box[1].stop - box[1].start))
        self.corner += np.array([columns.start, rows.start]) * self.resolution
        self.free, self.occupied = self.free[rows, columns], self.occupied[rows, columns]

    def coarsen(self) -> None:
        """Merges pixels that are finer than needed; a merged pixel is free only if all its pixels are, and occupied if
        one of them is."""
        factor = max(1, int(MIN_RESOLUTION * 1.001 / self.resolution))
        while self.free.size > COMFORTABLE_PIXELS * factor**2 and self.resolution * (factor + 1) <= 0.0501:
            factor += 1
        if factor > 1:
            self.free = ~_merged(~self.free, factor, outside=True)
            self.occupied = _merged(self.occupied, factor, outside=False)
            self.resolution *= factor

    def to_map(self, meters: FloatArray) -> FloatArray:
        """Points (N, 2) in meters from the lower-left corner of the cropped image, in the map's frame."""
        x, y, yaw = self.origin
        c, s = np.cos(yaw), np.sin(yaw)
        return np.asarray((meters + self.corner) @ np.array([[c, s], [-s, c]]) + [x, y])

    def from_map(self, points: FloatArray) -> FloatArray:
        """The inverse of `to_map`."""
        x, y, yaw = self.origin
        c, s = np.cos(yaw), np.sin(yaw)
        return np.asarray((points - [x, y]) @ np.array([[c, -s], [s, c]]) - self.corner)


def load_ros_map(path: str | Path) -> Track:
    """The race track in a ROS map, its centerline in the map's frame.

    The track is a ring of free space with the width of a race track: `loop: N` in the YAML selects the N-th longest, a
    starting position the one around it; otherwise it is `best_loop`. A starting position also sets the start line and
    the direction of travel; without one, the start is on the longest straight and the direction is counterclockwise.
    `notes` lists the decisions made.
    Raises InputError.
    """
    path = Path(path)
    header = parse_ros_map_yaml(read_text(path), str(path))
    notes: list[str] = []
    try:
        gray = read_gray(path.parent / header.image, header.mode)
        grid = Grid(
            np.ascontiguousarray(free_pixels(gray, header, notes)[::-1]),
            np.ascontiguousarray(occupied_pixels(gray, header)[::-1]),
            header.resolution,
            header.origin,
        )
        try:
            return _track_in(grid, header, path, notes)
        except InputError as error:
            raise InputError(f"{error}{_cause(gray, header, path.parent / header.image)}") from None
    except MemoryError:
        raise InputError(f"{path}: not enough memory for this map") from None
    except (shapely.errors.ShapelyError, np.linalg.LinAlgError) as error:
        raise InputError(f"{path}: its walls cannot be made into a track ({error})") from None


def _track_in(grid: Grid, header: MapHeader, path: Path, notes: list[str]) -> Track:
    if not grid.free.any() or grid.free.all():
        what = "free" if grid.free.any() else "occupied or unknown"
        raise InputError(f"{path}: every pixel is {what}; expected a closed track (check negate and the thresholds)")
    grid.crop()
    grid.coarsen()
    if grid.free.size > MAX_WORKING_PIXELS:
        raise InputError(f"{path}: a map of {grid.free.size / 1e6:.0f} million pixels is too large for a track")
    refuse_noise(grid.free, str(path))
    grid.free, specks = without_specks(grid.free, grid.resolution, 2 * RADII[0])
    if specks:
        notes.append(f"removed {specks} specks")
    loops = _loops(grid, notes)
    if not loops:
        raise InputError(f"{path}: {_why_no_loop(grid)}")
    loop, start = _choose(loops, grid, header, str(path), notes)
    left, right, obstacles = _walls(loop, grid)
    return assemble(path.stem, left, right, obstacles, source=str(path), start=start, notes=notes)


def _loops(grid: Grid, notes: list[str]) -> list[Loop]:
    """The plausible loops, longest first; smear is made free unless it is all that a loop goes around."""
    solid = solid_pixels(grid.free, grid.occupied, grid.resolution)
    cleared, pieces = without_smear(grid.free, solid, grid.resolution, CAR_WIDTH)
    for free, count in ((cleared, pieces), (grid.free, 0)) if pieces else ((grid.free, 0),):
        for radius in RADII:
            loops = _plausible_loops(free, solid, grid.resolution, radius)
            if loops:
                smear = count + max(loop.smear for loop in loops)
                if smear:
                    notes.append(f"removed {smear} pieces of smear: thin gray without an occupied pixel")
                return sorted(loops, key=lambda loop: -loop.length)
    return []


def _cause(gray: npt.NDArray[np.uint8], header: MapHeader, image: Path) -> str:
    """A property of the image that may be why it contains no track; empty if there is none."""
    transparent = transparent_share(image)
    if transparent > MANY_PIXELS:
        return (
            f"; {transparent:.0%} of the image is transparent, which map_server treats as occupied or unknown; "
            "expected an image without transparency (flattened onto white if that is free space)"
        )
    share, levels = between_share(gray, header)
    if share > MANY_PIXELS and levels > MANY_LEVELS:
        return (
            f"; {share:.0%} of the image are probabilities, as Cartographer writes them: lighter than unknown, "
            f"but not below free_thresh {header.free_thresh:g}; with free_thresh {LIKELY_FREE:g} they are free"
        )
    return ""


def _plausible_loops(free: Mask, solid: Mask, resolution: float, radius: float) -> list[Loop]:
    regions = [without_islands_of_smear(region, solid) for region in drivable_regions(free, resolution, radius)]
    loops = [loop for region, smear in regions for loop in loops_of(region, resolution, smear)]
    return [loop for loop in loops if loop.plausible and loop.length > 4.0]


def _why_no_loop(grid: Grid) -> str:
    if grid.free.size <= COMFORTABLE_PIXELS and _plausible_loops(grid.free, ~grid.free, grid.resolution, 0.08):
        return f"the only closed loop is too narrow for the car, which is {CAR_WIDTH} m wide"
    return "no closed loop of free space 0.6 to 5 m wide; expected a ring-shaped track with a wall on both sides"


def _choose(
    loops: list[Loop], grid: Grid, header: MapHeader, where: str, notes: list[str]
) -> tuple[Loop, tuple[float, float, float | None] | None]:
    """The loop, and the starting position on it, if there is one. Raises InputError if there is no such loop."""
    candidates, why = loops, ""
    if header.loop is not None:
        if header.loop > len(loops):
            raise InputError(f"{where}: loop is {header.loop}; this map has {_listed(loops, loops)}")
        candidates, why = [loops[header.loop - 1]], "as the map's YAML file says"
    for pose in header.starting_positions:
        point = grid.from_map(np.array([pose[:2]]))[0]
        around = [loop for loop in candidates if _covers(loop, point, grid.resolution)]
        if around:
            chosen = best_loop(around)
            _describe(chosen, loops, why or "around the starting position", notes)
            return chosen, pose
    if header.starting_positions:
        notes.append(f"no starting position is on {'the loop' if why else 'a closed track'}; ignored")
    chosen = best_loop(candidates)
    least_narrow = f"the least narrow of those at least {AS_LONG:.0%} as long as the longest"
    _describe(chosen, loops, why or ("the longest" if chosen is loops[0] else least_narrow), notes)
    return chosen, None


def _covers(loop: Loop, point: FloatArray, resolution: float) -> bool:
    column, row = np.floor(point / resolution).astype(int)
    rows, columns = loop.region.shape
    inside = 0 <= row < rows and 0 <= column < columns and bool(loop.region[row, column])
    return inside and float(np.hypot(*(loop.line - point).T).min()) < max(0.6, 0.6 * loop.median)


def _describe(loop: Loop, loops: list[Loop], why: str, notes: list[str]) -> None:
    number = next(i for i, other in enumerate(loops, start=1) if other is loop)
    which = f" (loop {number} of {len(loops)} possible loops: {why})" if len(loops) > 1 else ""
    notes.append(f"selected the loop of {loop.length:.1f} m, median width {loop.median:.2f} m{which}")
    others = [other for other in loops if other is not loop]
    if others:
        notes.append(f"`loop: N` in the map's YAML file selects {_listed(others, loops)}")
    if loop.small:
        notes.append(f"{len(loop.small)} small obstacles on the track")


def _listed(some: list[Loop], loops: list[Loop]) -> str:
    """Some of the loops with their numbers, as text."""
    return ", ".join(
        f"loop {i} ({loop.length:.1f} m, narrowest {loop.narrowest:.2f} m)"
        for i, loop in enumerate(loops, start=1)
        if any(loop is other for other in some)
    )


def _walls(loop: Loop, grid: Grid) -> tuple[list[FloatArray], list[FloatArray], list[FloatArray]]:
    polygon = region_walls(loop.region)
    left: list[FloatArray] = []
    right = [_to_meters(polygon.exterior, grid)]
    obstacles: list[FloatArray] = []
    for ring in polygon.interiors:
        label = _label_at(np.asarray(ring.coords), loop.holes)
        side = left if label in loop.inside else obstacles if label in loop.small else right
        side.append(_to_meters(ring, grid))
    return left, right, obstacles


def _to_meters(ring: shapely.LinearRing, grid: Grid) -> FloatArray:
    return grid.to_map((np.asarray(ring.coords, dtype=np.float64) + 0.5) * grid.resolution)


def _label_at(ring: FloatArray, holes: npt.NDArray[np.int32]) -> int:
    """The hole inside a ring (pixels): the most frequent label at and around its corners."""
    around = [np.rint(ring + np.array([dx, dy])).astype(np.intp) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    column, row = np.clip(np.vstack(around), 0, np.array(holes.shape[::-1]) - 1).T
    counts = np.bincount(holes[row, column])
    counts[:1] = 0
    return int(np.argmax(counts))


def _merged(mask: Mask, factor: int, outside: bool) -> Mask:
    """Blocks of factor x factor pixels, set if one of their pixels is; pixels outside of the image are `outside`."""
    rows, columns = (-(-size // factor) * factor for size in mask.shape)
    padded = np.full((rows, columns), outside)
    padded[: mask.shape[0], : mask.shape[1]] = mask
    return np.asarray(padded.reshape(rows // factor, factor, columns // factor, factor).any(axis=(1, 3)))


def _box(mask: Mask) -> tuple[slice, slice]:
    spans = []
    for axis in (1, 0):
        there = np.flatnonzero(mask.any(axis=axis))
        spans.append(slice(max(0, int(there[0]) - 4), min(mask.shape[1 - axis], int(there[-1]) + 5)))
    return spans[0], spans[1]
