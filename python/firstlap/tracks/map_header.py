"""Reads and checks the YAML file of a ROS map, without its image."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import parse_mapping

RESOLUTION = (0.002, 0.5)
MAX_NUMBER = 1e6


@dataclass(frozen=True)
class MapHeader:
    """resolution m/px; origin (x, y, yaw) of the lower-left corner, m and rad; thresholds 0..1.

    loop: which of the map's possible loops is the track, from 1, the longest; None: the reader chooses.
    """

    image: str
    resolution: float
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.196
    mode: str = "trinary"
    starting_positions: tuple[tuple[float, float, float], ...] = ()
    loop: int | None = None


def parse_ros_map_yaml(text: str, where: str) -> MapHeader:
    """The header in the text of a map's YAML file; `where` names the file in messages. Raises InputError."""
    data = parse_mapping(text, where)
    missing = [key for key in ("image", "resolution", "origin") if key not in data]
    if missing:
        raise InputError(f"{where}: missing '{missing[0]}'; a ROS map has image, resolution and origin: [x, y, yaw]")
    image = data["image"]
    if not isinstance(image, str) or not image.strip() or "\0" in image:
        raise InputError(f"{where}: image is {_short(image)}; expected a file name")
    resolution = number(data["resolution"], "resolution", where)
    if not RESOLUTION[0] <= resolution <= RESOLUTION[1]:
        raise InputError(f"{where}: resolution {resolution:g} m/px; expected {RESOLUTION[0]} to {RESOLUTION[1]}")
    occupied = number(data.get("occupied_thresh", 0.65), "occupied_thresh", where)
    free = number(data.get("free_thresh", 0.196), "free_thresh", where)
    for key, value in (("occupied_thresh", occupied), ("free_thresh", free)):
        if not 0.0 <= value <= 1.0:
            raise InputError(f"{where}: {key} is {value:g}; expected 0 to 1")
    mode = data.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise InputError(f"{where}: mode is {_short(mode)}; expected trinary, scale or raw")
    return MapHeader(
        image=image.strip(),
        resolution=resolution,
        origin=_pose(data["origin"], "origin", where),
        negate=_flag(data.get("negate", 0), "negate", where),
        occupied_thresh=occupied,
        free_thresh=free,
        mode=mode,
        starting_positions=_poses(data.get("starting_positions"), where),
        loop=_loop(data.get("loop"), where),
    )


def number(value: Any, key: str, where: str) -> float:
    """A finite number of plausible size. Raises InputError with the key otherwise."""
    try:
        if isinstance(value, str | int | float) and not isinstance(value, bool):
            result = float(value)
            if math.isfinite(result) and abs(result) <= MAX_NUMBER:
                return result
    except (ValueError, OverflowError):
        pass
    raise InputError(f"{where}: {key} is {_short(value)}; expected a finite number")


def _pose(value: Any, key: str, where: str) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(f"{where}: {key} is {_short(value)}; expected three numbers [x, y, yaw]")
    x, y, yaw = (number(item, key, where) for item in value)
    return x, y, yaw


def _poses(value: Any, where: str) -> tuple[tuple[float, float, float], ...]:
    if value is None:
        return ()
    if not isinstance(value, list) or len(value) > 1000:
        raise InputError(f"{where}: starting_positions is {_short(value)}; expected a list of [x, y, yaw]")
    return tuple(_pose(item, "starting_positions", where) for item in value)


def _loop(value: Any, where: str) -> int | None:
    if value is None:
        return None
    chosen = number(value, "loop", where)
    if chosen < 1 or chosen != int(chosen):
        raise InputError(f"{where}: loop is {_short(value)}; expected an integer from 1, the longest loop")
    return int(chosen)


def _flag(value: Any, key: str, where: str) -> bool:
    if isinstance(value, bool | int | float) and value in (0, 1):
        return bool(value)
    if isinstance(value, str) and value.strip().lower() in ("0", "1", "true", "false"):
        return value.strip().lower() in ("1", "true")
    raise InputError(f"{where}: {key} is {_short(value)}; expected 0 or 1")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
