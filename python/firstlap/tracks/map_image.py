"""The image of a ROS map: reads image files and classifies pixels."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from firstlap.common.errors import InputError
from firstlap.tracks.map_header import MapHeader

MAX_PIXELS = 64_000_000
MAX_FILE_BYTES = 256_000_000
UNKNOWN_GRAY = 205
LIKELY_FREE = 0.45
"""Occupancy below which a pixel of a probability map may be treated as free; unknown is 0.5."""


def read_gray(path: Path, mode: str = "trinary") -> npt.NDArray[np.uint8]:
    """Gray levels (rows, columns), top row first; transparent pixels are treated as in map_server's mode.

    Raises InputError if the file is missing, not an image, damaged, or larger than `MAX_PIXELS`.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; the map's 'image' must name an image file next to the YAML file")
    if not path.is_file():
        raise InputError(f"{path}: no such image; the map's 'image' must name an image file next to the YAML file")
    if path.stat().st_size > MAX_FILE_BYTES:
        raise InputError(f"{path}: larger than {MAX_FILE_BYTES // 1_000_000} MB, too large for a map")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                _check_size(path, image.size)
                return _to_gray(image, mode)
    except InputError:
        raise
    except MemoryError:
        raise InputError(f"{path}: too large to decode in memory") from None
    except Exception as error:  # Pillow's decoders raise nearly anything for broken bytes
        raise InputError(
            f"{path}: not a readable image ({type(error).__name__}: {error}); expected a PNG or PGM"
        ) from None


def _check_size(path: Path, size: tuple[int, int]) -> None:
    width, height = size
    if width * height > MAX_PIXELS:
        raise InputError(f"{path}: {width} x {height} pixels; at most {MAX_PIXELS // 1_000_000} million are supported")
    if width < 3 or height < 3:
        raise InputError(f"{path}: {width} x {height} pixels is too small for a map")


def _to_gray(image: Image.Image, mode: str) -> npt.NDArray[np.uint8]:
    if image.mode in ("1", "L") and not _has_alpha(image):
        return np.asarray(image.convert("L"))
    if image.mode.startswith(("I", "F")):
        return _from_numbers(np.asarray(image, dtype=np.float64), image.mode)
    rgba = np.asarray(image.convert("RGBA"))
    gray = rgba[..., :3].mean(axis=2, dtype=np.float32).astype(np.uint8)
    if _has_alpha(image) and mode != "raw":
        gray = _with_alpha(gray, rgba, mode)
    return np.asarray(gray, dtype=np.uint8)


def _has_alpha(image: Image.Image) -> bool:
    return "A" in image.getbands() or "transparency" in image.info


def _with_alpha(gray: npt.NDArray[np.uint8], rgba: npt.NDArray[np.uint8], mode: str) -> npt.NDArray[np.uint8]:
    """As in map_server: the mean of the colors and the opacity; in mode scale, pixels that are not opaque are
    unknown."""
    opaque = rgba[..., 3] == 255
    if mode == "scale":
        return np.where(opaque, gray, np.uint8(UNKNOWN_GRAY))
    shade = np.rint(rgba.mean(axis=2, dtype=np.float32)).astype(np.uint8)
    # map_server treats a mean of 205 with full opacity as free; map savers mean unknown by it, which is kept.
    return np.where(opaque & (gray == UNKNOWN_GRAY), gray, shade)


def transparent_share(path: Path) -> float:
    """Share of an image's pixels that are more transparent than opaque, 0 to 1."""
    with Image.open(path) as image:
        if not _has_alpha(image):
            return 0.0
        return float((np.asarray(image.convert("RGBA"))[..., 3] < 128).mean())


def _from_numbers(values: npt.NDArray[np.float64], mode: str) -> npt.NDArray[np.uint8]:
    """16-bit, 32-bit and float images, scaled to 0..255 by the range of their type or content."""
    values = np.nan_to_num(values, nan=UNKNOWN_GRAY, posinf=UNKNOWN_GRAY, neginf=0.0)
    high = float(values.max())
    if mode.startswith("F") and high <= 1.0:
        values = values * 255.0
    elif mode.startswith("I;16") or high > 255.0:
        values = values / 257.0
    return np.clip(values, 0, 255).astype(np.uint8)


def free_pixels(gray: npt.NDArray[np.uint8], header: MapHeader, notes: list[str]) -> npt.NDArray[np.bool_]:
    """Free pixels (rows, columns) as in map_server, which checks "occupied" first; unknown is not free."""
    occupancy = _occupancy(header)
    free = (occupancy < header.free_thresh) & ~(occupancy > header.occupied_thresh)
    if header.free_thresh > header.occupied_thresh:
        notes.append(
            f"free_thresh {header.free_thresh:g} is above occupied_thresh {header.occupied_thresh:g}: as in "
            "map_server, pixels above occupied_thresh are occupied"
        )
    if header.mode != "raw" and not header.negate and free[UNKNOWN_GRAY] and (gray == UNKNOWN_GRAY).any():
        free[UNKNOWN_GRAY] = False
        notes.append(f"gray {UNKNOWN_GRAY} is what map savers write for unknown; not treated as free")
    return np.asarray(free[gray])


def between_share(gray: npt.NDArray[np.uint8], header: MapHeader) -> tuple[float, int]:
    """Share of pixels (0 to 1), and number of gray levels, that are likely free but above free_thresh.

    Cartographer writes such maps: each pixel's probability, and 128 for unknown.
    """
    occupancy = _occupancy(header)
    between = (occupancy >= header.free_thresh) & (occupancy < LIKELY_FREE)
    between[UNKNOWN_GRAY] = False
    counts = np.bincount(gray.ravel(), minlength=len(occupancy))[between]
    return float(counts.sum() / gray.size), int((counts > 0).sum())


def occupied_pixels(gray: npt.NDArray[np.uint8], header: MapHeader) -> npt.NDArray[np.bool_]:
    """Occupied pixels (rows, columns) as in map_server; unknown is not occupied."""
    return np.asarray((_occupancy(header) > header.occupied_thresh)[gray])


def _occupancy(header: MapHeader) -> npt.NDArray[np.float64]:
    """(256,) occupancy of each gray level, 0 to 1."""
    levels = np.arange(256)
    if header.mode == "raw":
        return np.asarray(np.where(levels <= 100, levels / 100.0, 1.0))
    return np.asarray(levels / 255.0 if header.negate else (255 - levels) / 255.0)
