"""Recordings as what a mapper sees."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.car_file import Car
from firstlap.errors import InputError
from firstlap.mapping.observation import Observation, Scan
from firstlap.mapping.poses import between
from firstlap.tracks.track import FloatArray

NEEDED = ("ranges", "angle_min", "angle_increment", "stamps")


def is_recording(source: str) -> bool:
    """Whether a command's argument names a recording rather than a track."""
    return Path(source).suffix.lower() == ".npz"


@dataclass(frozen=True)
class RecordedDrive:
    """Scans with odometry poses (N, 3) at their stamps (N,) [s]."""

    car: Car
    ranges: npt.NDArray[np.float32]
    stamps: FloatArray
    poses: FloatArray
    header: dict[str, float]

    @property
    def scans(self) -> int:
        """How many there are."""
        return len(self.ranges)

    def observations(self) -> Iterator[Observation]:
        """One after the other."""
        for i in range(self.scans):
            before = max(i - 1, 0)
            motion = between(self.poses[before], self.poses[i])
            dt = float(self.stamps[i] - self.stamps[before]) or 1.0
            yield Observation(
                time=float(self.stamps[i]),
                speed=float(motion[0]) / dt,
                yaw_rate=float(motion[2]) / dt,
                motion=motion,
                scan=lambda i=i: Scan(ranges=np.ascontiguousarray(self.ranges[i]), **self.header),  # type: ignore[misc]
            )


def read_recording(path: str, car: Car) -> RecordedDrive:
    """A `.npz` with ranges, angle_min, angle_increment, stamps and odom (stamp, x, y, yaw). Raises InputError."""
    try:
        with np.load(path, allow_pickle=False) as data:
            return _from_arrays({name: data[name] for name in data.files}, path, car)
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        if isinstance(error, FileNotFoundError):
            raise InputError(f"{path}: no such file") from None
        raise InputError(f"{path}: not a recording ({error}); expected a numpy .npz") from None


def _from_arrays(data: dict[str, npt.NDArray[Any]], path: str, car: Car) -> RecordedDrive:
    missing = [name for name in NEEDED if name not in data]
    if missing:
        raise InputError(f"{path}: no '{missing[0]}'; a recording has {', '.join(NEEDED)}")
    ranges, stamps = data["ranges"], data["stamps"]
    if ranges.ndim != 2 or len(ranges) < 2 or len(stamps) != len(ranges):
        raise InputError(f"{path}: no scans; expected ranges (N, beams) and stamps (N,), at least 2")
    if not (np.diff(stamps) > 0).all():
        raise InputError(f"{path}: stamps do not increase")
    columns = str(data.get("odom_columns", "")).split(",")
    if "odom" not in data or columns[:4] != ["stamp", "x", "y", "yaw"] or len(data["odom"]) < 2:
        raise InputError(f"{path}: no odometry; expected odom with columns stamp, x, y, yaw")
    odom = data["odom"]
    yaw = np.unwrap(odom[:, 3])
    poses = np.column_stack([np.interp(stamps, odom[:, 0], values) for values in (odom[:, 1], odom[:, 2], yaw)])
    header = {
        "angle_min": float(data["angle_min"]),
        "angle_increment": float(data["angle_increment"]),
        "time_increment": float(data.get("time_increment", 0.0)),
        "range_min": float(data.get("range_min", 0.02)),
        "range_max": float(data.get("range_max", 30.0)),
    }
    return RecordedDrive(_with_laser(car, data), ranges.astype(np.float32), stamps, poses, header)


def _with_laser(car: Car, data: dict[str, npt.NDArray[Any]]) -> Car:
    if "laser_x_in_base" not in data:
        return car
    core = _core.Car(car.core)
    core.set("geometry", "laser_x", float(data["laser_x_in_base"]))
    return Car(car.name, core, car.source)
