"""The LiDAR's mounting in a recording: from the user, or from /tf_static and /tf as in the driving node."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.text import to_side
from firstlap.config.car_file import Car
from firstlap.perception.frames import Frames, mount_of, placed
from firstlap.perception.scan import Mount, set_laser
from firstlap.recordings.recording import Recording

OPTION = "--laser"
EXPECTED = "X,Y,YAW[,ROLL]: meters ahead and left of base_link, degrees; ROLL 180 if upside down"
FURTHEST = 2.0
"""[m] Maximum distance of the LiDAR from base_link for a car of this size."""
LOOKED_AT = 500
"""Number of /tf messages searched if /tf_static has no mounting."""

Floats = npt.NDArray[np.float64]


class Mounting(NamedTuple):
    """mount: None if unknown. source: where it is from. missing: name of the missing transform."""

    mount: Mount | None
    source: str
    missing: str = ""

    @property
    def remarks(self) -> list[str]:
        """The mounting, in one line."""
        if self.missing:
            return [f"no transform {self.missing}: the LiDAR mounting of {self.source} is assumed; see {OPTION}"]
        if self.mount is None:
            return []
        return [f"LiDAR mounting: {described(self.mount)}, from {self.source}"]


UNKNOWN = Mounting(None, "the car's parameters")


def described(mount: Mount) -> str:
    """As text, in meters and degrees."""
    aside = f" and {to_side(mount.y, 'left', 'right')}" if round(mount.y, 3) else ""
    turned = f", rotated by {math.degrees(mount.yaw):.0f}°" if abs(mount.yaw) > math.radians(0.5) else ""
    hung = ", upside down" if mount.upside_down else ""
    return f"{to_side(mount.x, 'ahead', 'behind')}{aside} of base_link{turned}{hung}"


def parse_laser(text: str) -> Mount:
    """Parses `--laser`. Raises InputError."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 4) or not all(map(math.isfinite, numbers)):
        raise InputError(f"{OPTION} {text[:60]}: expected {EXPECTED}")
    x, y, yaw, roll = (*numbers, 0.0)[:4]
    if math.hypot(x, y) > FURTHEST:
        raise InputError(f"{OPTION} {text[:60]}: {math.hypot(x, y):g} m from base_link; allowed: up to {FURTHEST:g} m")
    try:
        return mount_of(placed(x, y, math.radians(yaw), math.radians(roll)))
    except ValueError as error:
        raise InputError(f"{OPTION} {text[:60]}: {error}; expected {EXPECTED}") from None


def mounting_by_frames(
    static: Iterable[Any], moving: Iterable[Any], bases: list[str], frame: str, where: str
) -> Mounting:
    """The mounting of the scans' `frame` from the frame tree. Raises InputError if it is not supported.

    static, moving: messages of /tf_static and /tf. bases: possible frames of the car, in order.
    """
    frames, heard = Frames(), False
    for message in static:
        frames.add(message)
        heard = True
    found = _mounting(frames, bases, frame, "/tf_static", where)
    for _, message in zip(range(LOOKED_AT if found is None else 0), moving, strict=False):
        frames.add(message)
        heard = True
        found = found or _mounting(frames, bases, frame, "/tf", where)
    return found or UNKNOWN._replace(missing=f"from {bases[0]} to {frame}" if heard else "")


def _mounting(frames: Frames, bases: list[str], frame: str, source: str, where: str) -> Mounting | None:
    for base in bases:
        place = frames.find(base, frame)
        if place is None or base == frame:
            continue
        try:
            return Mounting(mount_of(place), f"{source} ({base} to {frame})")
        except ValueError as error:
            raise InputError(
                f"{where}: {error}, by {source} ({base} to {frame}); set its mounting with {OPTION}"
            ) from None
    return None


def turned(headers: Floats, mount: Mount | None) -> Floats:
    """(N, 5) headers as in Recording, for a LiDAR that points forward."""
    if mount is None:
        return headers
    angles = [mount.turned(angle_min, angle_increment) for angle_min, angle_increment in headers[:, :2].tolist()]
    return np.column_stack([np.array(angles).reshape(-1, 2), headers[:, 2:]])


def car_of(recording: Recording, car: Car) -> Car:
    """The car with the recording's LiDAR mounting. Raises InputError if it is out of range."""
    if recording.laser is None:
        return car
    core = _core.Car(car.core)
    try:
        set_laser(core, recording.laser.x, recording.laser.y)
        core.validate()
    except ValueError as error:
        raise InputError(f"{recording.source}: LiDAR: {error}; set its mounting with {OPTION}") from None
    return Car(car.name, core, car.source)
