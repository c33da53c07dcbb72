"""Finds the free pixels of a map that are the track, and the walls inside and outside of its loop."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt
import shapely
from scipy import ndimage

from firstlap.common.errors import InputError
from firstlap.tracks.medial import contours, is_closed
from firstlap.tracks.track import FloatArray

Mask = npt.NDArray[np.bool_]
EIGHT = np.ones((3, 3), dtype=np.bool_)
PLAUSIBLE = (0.6, 5.0)
SMALL_OBSTACLE = 0.7
MAX_SMEAR = 0.5
"""[m] Thickness up to which gray is smear. Thicker gray is ground that was never seen."""
AS_LONG = 0.85
"""Share of the longest loop's length from which a loop that is less narrow is preferred."""
MAX_HOLES = 6
MAX_REGIONS = 6
MAX_WALL_PIECES = 5_000
MAX_FREE_PIECES = 100_000
SAMPLING = (0.08, 0.2)
COMFORTABLE_CELLS = 1_500_000


@dataclass(frozen=True, eq=False)
class Loop:
    """A closed loop: its drivable region, the holes (labels) inside of it, and its dimensions in m. smear: number of
    holes of its region that were made free."""

    region: Mask
    holes: npt.NDArray[np.int32]
    inside: tuple[int, ...]
    small: tuple[int, ...]
    line: FloatArray
    length: float
    narrowest: float
    median: float
    on_border: float
    smear: int

    @property
    def plausible(self) -> bool:
        """Whether this looks like a race track rather than the margin around one."""
        return PLAUSIBLE[0] <= self.median <= PLAUSIBLE[1] and self.on_border < 0.4


def refuse_noise(free: Mask, where: str) -> None:
    """Raises InputError if walls or free space have more pieces than any real map: noise, a photograph."""
    for mask, neighbors, limit, what in (
        (~free, EIGHT, MAX_WALL_PIECES, "wall"),
        (free, None, MAX_FREE_PIECES, "free space"),
    ):
        _, pieces = ndimage.label(mask, structure=neighbors)
        if pieces > limit:
            raise InputError(
                f"{where}: {pieces} separate pieces of {what} (at most {limit}); expected a map of a track, "
                "not noise (check the image, negate and the thresholds)"
            )


def without_specks(free: Mask, resolution: float, reach: float) -> tuple[Mask, int]:
    """Free pixels with lone occupied specks (about 0.12 m, nothing else within `reach` m) made free."""
    occupied = ~free
    near = ndimage.distance_transform_edt(free) * resolution <= 0.5 * reach
    clusters, count = ndimage.label(near, structure=EIGHT)
    limit = max(4.0, 0.012 / resolution**2)
    pixels = np.bincount(clusters[occupied], minlength=count + 1)
    small = pixels <= limit
    small[0] = False
    edge = np.concatenate([clusters[0], clusters[-1], clusters[:, 0], clusters[:, -1]])
    small[edge] = False
    for label, box in enumerate(ndimage.find_objects(clusters), start=1):
        if small[label] and box is not None:
            size = max(box[0].stop - box[0].start, box[1].stop - box[1].start) * resolution - reach
            small[label] = size < max(0.2, 2.5 * resolution)
    return np.asarray(free | (small[clusters] & occupied)), int(small.sum())


def solid_pixels(free: Mask, occupied: Mask, resolution: float) -> Mask:
    """Pixels that make what they belong to solid: the map's own threshold calls them occupied, or there is gray around
    them thicker than `MAX_SMEAR`. Other gray is what a scan matcher smears over the track."""
    thickness = 2.0 * resolution * ndimage.distance_transform_edt(~free)
    return np.asarray(~free & (occupied | (thickness > MAX_SMEAR)))


def without_smear(free: Mask, solid: Mask, resolution: float, gap: float) -> tuple[Mask, int]:
    """Free pixels with smear made free, and the number of its pieces.

    Pieces of pixels that are not free, with gaps of less than `gap` m between them, are one thing; it is smear if none
    of its pixels is solid. So a dashed gray line that continues a wall stays.
    """
    to_piece = ndimage.distance_transform_edt(free) * resolution
    things, count = ndimage.label(to_piece <= 0.5 * gap, structure=EIGHT)
    is_solid = np.zeros(count + 1, dtype=np.bool_)
    is_solid[things[solid]] = True
    smear = ~free & ~is_solid[things]
    return np.asarray(free | smear), int(ndimage.label(smear, structure=EIGHT)[1])


def without_islands_of_smear(region: Mask, solid: Mask) -> tuple[Mask, int]:
    """A region with its holes that hold no solid pixel filled, and their number; none if all are like that."""
    holes = _holes(region)
    is_smear = np.ones(int(holes.max()) + 1, dtype=np.bool_)
    is_smear[0] = False
    is_smear[holes[solid]] = False
    count = int(is_smear.sum())
    if count == len(is_smear) - 1:
        return region, 0
    return np.asarray(region | is_smear[holes]), count


def _holes(region: Mask) -> npt.NDArray[np.int32]:
    """The holes of a region, labeled from 1; 0 in the region and outside of it."""
    outside, _ = ndimage.label(np.pad(~region, 1, constant_values=True), structure=EIGHT)
    holes = np.where(outside == outside[0, 0], 0, outside)[1:-1, 1:-1]
    return np.asarray(np.maximum(holes - 1, 0) if outside[0, 0] == 1 else holes, dtype=np.int32)


def drivable_regions(free: Mask, resolution: float, radius: float) -> list[Mask]:
    """The areas that a disk of `radius` meters can sweep, one mask per connected region, largest first.

    Holes in a wall narrower than the disk are closed; corners that it cannot reach are restored.
    """
    clearance = (ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] - 0.5) * resolution
    cores, count = ndimage.label(clearance > radius)
    if count == 0:
        return []
    areas = np.bincount(cores.ravel())[1:] * resolution**2
    order = [int(i) + 1 for i in np.argsort(-areas)[:MAX_REGIONS] if areas[i] > 0.3]
    distance, nearest = ndimage.distance_transform_edt(cores == 0, return_indices=True)
    swept = np.where(free & (distance * resolution <= radius + 0.5 * resolution), cores[tuple(nearest)], 0)
    regions = (_with_corners(swept == label, free, swept, 2.0 * radius / resolution) for label in order)
    return [_largest_part(region) for region in regions]


def _largest_part(region: Mask) -> Mask:
    """The largest part connected by pixel sides; a connection by corners is not passable."""
    parts, _ = ndimage.label(region)
    return np.asarray(parts == 1 + int(np.argmax(np.bincount(parts.ravel())[1:])))


def _with_corners(region: Mask, free: Mask, swept: npt.NDArray[np.int32], reach: float) -> Mask:
    """The region plus the small free corners that touch it along a single stretch; leaks touch several."""
    rest, _ = ndimage.label(free & (swept == 0))
    grown = region.copy()
    touching = np.unique(rest[ndimage.binary_dilation(region)])
    boxes = ndimage.find_objects(rest)
    for label in touching[touching > 0][:5000]:
        box = boxes[label - 1]
        if max(box[0].stop - box[0].start, box[1].stop - box[1].start) > reach:
            continue
        window = tuple(slice(max(0, part.start - 2), part.stop + 2) for part in box)
        corner = rest[window] == label
        ring = ndimage.binary_dilation(corner) & ~corner
        _, contacts = ndimage.label(ring & region[window], structure=EIGHT)
        others = ring & (swept[window] > 0) & ~region[window]
        if contacts == 1 and not others.any():
            grown[window] |= corner
    return np.asarray(grown)


def loops_of(region: Mask, resolution: float, smear: int = 0) -> list[Loop]:
    """All loops of a region: every choice of its large holes that a single closed line can enclose."""
    holes = _holes(region)
    sizes = {label: _extent(box) * resolution for label, box in enumerate(ndimage.find_objects(holes), 1) if box}
    ranked = sorted(sizes, key=lambda label: -sizes[label])
    large = [label for label in ranked if sizes[label] >= SMALL_OBSTACLE][:MAX_HOLES] or ranked[:1]
    small = tuple(label for label in ranked if label not in large)
    if not large:
        return []
    # Distances are computed on the full grid and then subsampled, so that no thin wall is missed.
    step = _sampling(region, resolution)
    window, corner = _window(region, step)
    full = np.pad(np.where(region, 0, np.where(holes > 0, holes, -1))[window], 1, constant_values=-1)
    within = {label: np.argwhere(full == label)[:1] / step for label in large}
    to = {
        label: (ndimage.distance_transform_edt(full != label)[::step, ::step] - 0.5) * resolution
        for label in [-1, *large]
    }
    border = _border_share(region)
    loops = []
    for choice in product((True, False), repeat=len(large)):
        inside = tuple(label for label, chosen in zip(large, choice, strict=True) if chosen)
        outer = [-1, *(label for label in large if label not in inside)]
        if not inside:
            continue
        d_in = np.minimum.reduce([to[label] for label in inside])
        d_out = np.minimum.reduce([to[label] for label in outer])
        line = _around(d_out - d_in, [within[label] for label in inside])
        if line is None:
            continue
        row, column = np.rint(line[:, ::-1]).astype(np.intp).T
        width = d_in[row, column] + d_out[row, column]
        meters = (line * step + corner) * resolution
        length = float(np.hypot(*np.diff(meters, axis=0).T).sum())
        loops.append(
            Loop(region, holes, inside, small, meters - 0.5 * resolution, length, float(width.min()),
                 float(np.median(width)), border, smear)
        )  # fmt: skip
    return loops


def _sampling(region: Mask, resolution: float) -> int:
    """Sampling step, in pixels, of the loop search: fine, but coarser for large regions."""
    box = ndimage.find_objects(region.astype(np.uint8))[0]
    cells = (box[0].stop - box[0].start) * (box[1].stop - box[1].start)
    finest, coarsest = (max(1, int(spacing / resolution)) for spacing in SAMPLING)
    return max(finest, min(coarsest, int(np.ceil(np.sqrt(cells / COMFORTABLE_CELLS)))))


def _window(region: Mask, step: int) -> tuple[tuple[slice, slice], FloatArray]:
    """The window of the image around a region, aligned to the step, and its corner (column, row)."""
    box = ndimage.find_objects(region.astype(np.uint8))[0]
    first = [max(0, (part.start - 1) // step * step) for part in box]
    window = (slice(first[0], box[0].stop + 1), slice(first[1], box[1].stop + 1))
    return window, np.array(first[::-1], dtype=np.float64)


def _around(level: FloatArray, islands: list[FloatArray]) -> FloatArray | None:
    """The zero contour (N, 2), in grid units x, y, that encloses every island; None if there is none."""
    for line in sorted(contours(level, 0.0), key=len, reverse=True)[:20]:
        if is_closed(line):
            area = shapely.Polygon(line)
            shapely.prepare(area)
            if all(bool(shapely.contains_xy(area, float(i[0][1]), float(i[0][0]))) for i in islands):
                return line
    return None


def _extent(box: tuple[slice, ...]) -> float:
    return float(np.hypot(box[0].stop - box[0].start, box[1].stop - box[1].start))


def _border_share(region: Mask) -> float:
    """Share of the image border that the region touches: near 1 for the margin around a track."""
    edge = np.concatenate([region[0], region[-1], region[:, 0], region[:, -1]])
    return float(edge.mean())


def best_loop(loops: list[Loop]) -> Loop:
    """Of the loops at least `AS_LONG` times as long as the longest, the one with the largest minimum width."""
    longest = max(loop.length for loop in loops)
    return max((loop for loop in loops if loop.length >= AS_LONG * longest), key=lambda loop: loop.narrowest)


def region_walls(region: Mask) -> shapely.Polygon:
    """The region's boundary as a polygon with holes, in pixels (centers at integers), smoothed."""
    padded = np.pad(region, 1).astype(np.float64)
    # Just above one half, so that wall pixels that touch at a corner are connected: a thin diagonal is a wall.
    rings = [line - 1.0 for line in contours(padded, 0.505)]
    rings.sort(key=lambda ring: -float(shapely.Polygon(ring).area))
    for passes in (4, 2, 1, 0):
        smooth = [_smoothed(ring, passes) for ring in rings]
        polygon = shapely.Polygon(smooth[0], smooth[1:])
        if polygon.is_valid:
            break
    simple = polygon.simplify(0.45, preserve_topology=True)
    return simple if simple.is_valid and isinstance(simple, shapely.Polygon) else polygon


def _smoothed(ring: FloatArray, passes: int) -> FloatArray:
    points = ring[:-1]
    if len(points) < 24:
        return ring
    for _ in range(passes):
        points = 0.25 * np.roll(points, 1, axis=0) + 0.5 * points + 0.25 * np.roll(points, -1, axis=0)
    return np.vstack([points, points[:1]])
