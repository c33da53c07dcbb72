"""The picture of a ROS map: from any image file to which pixels are free."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from firstlap.errors import InputError
from firstlap.tracks.map_header import MapHeader

MAX_PIXELS = 64_000_000
MAX_FILE_BYTES = 256_000_000
UNKNOWN_GRAY = 205


def read_gray(path: Path) -> npt.NDArray[np.uint8]:
    """Gray levels (rows, columns), top row first; transparent pixels get the level that maps use for unknown.

    Raises InputError for a file that is missing, no image, broken, or larger than `MAX_PIXELS`.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; the map's 'image' must name a picture beside the YAML file")
    if not path.is_file():
        raise InputError(f"{path}: no such image; the map's 'image' must name a picture beside the YAML file")
    if path.stat().st_size > MAX_FILE_BYTES:
        raise InputError(f"{path}: larger than {MAX_FILE_BYTES // 1_000_000} MB, which no map is")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                _check_size(path, image.size)
                return _to_gray(image)
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
        raise InputError(f"{path}: {width} x {height} pixels; at most {MAX_PIXELS // 1_000_000} million are read")
    if width < 3 or height < 3:
        raise InputError(f"{path}: {width} x {height} pixels is too small for a map")


def _to_gray(image: Image.Image) -> npt.NDArray[np.uint8]:
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L"))
    if image.mode.startswith(("I", "F")):
        return _from_numbers(np.asarray(image, dtype=np.float64), image.mode)
    rgba = np.asarray(image.convert("RGBA"))
    gray = rgba[..., :3].mean(axis=2, dtype=np.float32).astype(np.uint8)
    gray[rgba[..., 3] < 128] = UNKNOWN_GRAY
    return np.asarray(gray, dtype=np.uint8)


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
    """Free pixels (rows, columns) as map_server decides; unknown is not free."""
    free = _occupancy(header) < header.free_thresh
    if header.mode != "raw" and not header.negate and free[UNKNOWN_GRAY] and (gray == UNKNOWN_GRAY).any():
        free[UNKNOWN_GRAY] = False
        notes.append(f"gray {UNKNOWN_GRAY} is what map savers write for unknown; not taken as free")
    return np.asarray(free[gray])


def occupied_pixels(gray: npt.NDArray[np.uint8], header: MapHeader) -> npt.NDArray[np.bool_]:
    """Occupied pixels (rows, columns) as map_server decides; unknown is not occupied."""
    return np.asarray((_occupancy(header) > header.occupied_thresh)[gray])


def _occupancy(header: MapHeader) -> npt.NDArray[np.float64]:
    """(256,) how occupied each gray level says that a pixel is, 0 to 1."""
    levels = np.arange(256)
    if header.mode == "raw":
        return np.asarray(np.where(levels <= 100, levels / 100.0, 1.0))
    return np.asarray(levels / 255.0 if header.negate else (255 - levels) / 255.0)
