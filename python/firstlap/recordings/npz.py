"""Recordings as numpy files: arrays `ranges`, `angle_min`, `angle_increment` and optional others."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.perception.scan import Mount, judge
from firstlap.recordings.clock import USUAL_PERIOD, periods, sweeps, timeline, usual_period
from firstlap.recordings.laser import OPTION, UNKNOWN, Mounting, turned
from firstlap.recordings.messages import check_magic
from firstlap.recordings.paths import name_of
from firstlap.recordings.recording import Recording
from firstlap.recordings.scans import Findings
from firstlap.recordings.state import Series, Sources, commands_at, in_radians, series, states_at
from firstlap.recordings.topics import NONE, Topics

Floats = npt.NDArray[np.float64]
HEADER = {"angle_min": None, "angle_increment": None, "time_increment": 0.0, "range_min": 0.02, "range_max": 30.0}
"""Header fields and defaults; None: required."""
LASER_X = "laser_x_in_base"
ZIP_MAGIC = b"PK\x03\x04"
STEERING_ONLY = "angular_control"
"""A column of command tables without a speed."""
POSE_COLUMNS = ("x", "y", "yaw")
COMMANDS = ("cmd", "nav")
"""Tables of commands."""
PER_SCAN = ("speed", "yaw_rate", "steering_angle", "steer")
"""Arrays with a value per scan."""


def load_npz(path: Path, wanted: Topics) -> Recording:
    """The recording in the file. Raises InputError.

    ranges (N, B) [m]; angle_min, angle_increment [rad]; optional: time_increment [s], range_min, range_max [m],
    stamps and bag_stamps (N,) [s], speed, yaw_rate, steering_angle or steer (N,), laser_x_in_base [m], pose_global
    (N, 3) x, y, yaw in the map; tables with their columns named in NAME_columns: odom (stamp, x, y, yaw, and may be
    vx, yaw_rate) and commands `cmd` or `nav` ([bag_]stamp and speed, steer, or
    angular_control alone).
    """
    arrays = _read(path)
    ranges = _ranges(arrays, path)
    count = len(ranges)
    header = [_single(arrays, key, default, path) for key, default in HEADER.items()]
    stamps, remarks = _stamps(_per_scan(arrays, "stamps", count, path), count)
    remarks += _judged(ranges, header, _whole(stamps - stamps[0]), path)
    logged = _per_scan(arrays, "bag_stamps", count, path)
    headers = np.tile(np.array(header), (count, 1))
    stamps = stamps + sweeps(headers[:, 2], [ranges.shape[1]] * count, _whole(stamps - stamps[0])) / 1e9
    origin = float(stamps[0])
    line = timeline(_whole(stamps - origin), _whole((stamps if logged is None else logged) - origin))
    mounting = _mounting(arrays, wanted, path)
    remarks += [*line.remarks, *mounting.remarks]
    times = (line.times - line.times[0]) / 1e9
    tables = _Tables(arrays, origin, None if logged is None else float(np.median(logged - stamps)))
    held = _sources(tables, times, wanted, path)
    held = replace(held, commands=in_radians(held.commands, 1, remarks), steering=in_radians(held.steering, 0, remarks))
    found = states_at(times, held, wanted.speed)
    poses = _poses(arrays, count, path)
    return Recording(
        name=name_of(path),
        source=str(path),
        ranges=ranges,  # type: ignore[arg-type]
        headers=turned(headers, mounting.mount),
        start=origin,
        stamps=times,
        dts=periods(line.times),
        states=found.states,
        sources={**found.sources, "laser": mounting.source},
        commands=commands_at(times, held.commands),
        poses=poses if poses is not None else None if held.poses is None else held.poses.at(times),
        frame="map" if poses is not None else "odom" if held.poses is not None else "",
        odometry=None if held.poses is None else held.poses.at(times),
        laser=mounting.mount,
        remarks=tuple(remarks + found.remarks),
        topics={"scan": "ranges", **({"drive": held.commands.name} if held.commands else {})},
    )


def _read(path: Path) -> dict[str, npt.NDArray[Any]]:
    check_magic(path, ZIP_MAGIC, "an .npz recording of scans")
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            arrays = {key: file[key] for key in file}
    except OSError:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError):
        raise InputError(f"{path}: is cut off or damaged") from None
    except Exception:  # the libraries may raise any exception for invalid bytes
        raise InputError(f"{path}: not an .npz recording of scans, or damaged") from None
    return {key: array for key, array in arrays.items() if isinstance(array, np.ndarray)}


def _mounting(arrays: Mapping[str, npt.NDArray[Any]], wanted: Topics, path: Path) -> Mounting:
    if wanted.laser is not None:
        return Mounting(wanted.laser, OPTION)
    if LASER_X not in arrays:
        return UNKNOWN
    return Mounting(Mount(_single(arrays, LASER_X, None, path), 0.0, 0.0, False), LASER_X)


def _ranges(arrays: Mapping[str, npt.NDArray[Any]], path: Path) -> npt.NDArray[np.float32]:
    missing = [key for key in ("ranges", "angle_min", "angle_increment") if key not in arrays]
    if missing:
        raise InputError(f"{path}: no LaserScan: '{missing[0]}' is missing; expected ranges, angle_min and "
                         "angle_increment")  # fmt: skip
    ranges = np.atleast_2d(arrays["ranges"])
    if ranges.dtype.kind not in "fiu" or ranges.ndim != 2 or 0 in ranges.shape:
        raise InputError(f"{path}: 'ranges' is {ranges.dtype} {ranges.shape}; expected numbers (scans, beams)")
    return np.ascontiguousarray(ranges, dtype=np.float32)


def _single(arrays: Mapping[str, npt.NDArray[Any]], key: str, default: float | None, path: Path) -> float:
    value = arrays.get(key)
    if value is None and default is not None:
        return default
    if value is None or value.dtype.kind not in "fiu" or value.size != 1 or not np.isfinite(value).all():
        raise InputError(f"{path}: '{key}' is not one finite number")
    return float(value.reshape(-1)[0])


def _judged(
    ranges: npt.NDArray[np.float32], header: list[float], stamps: npt.NDArray[np.int64], path: Path
) -> list[str]:
    """The remarks of the scan check. Raises InputError if no scan is valid."""
    findings, period = Findings(), usual_period(stamps) / 1e9
    for one in ranges:
        findings.keeps(judge(_core.LaserScan(np.ascontiguousarray(one, dtype=np.float32), *header), period))
    if not findings.usable:
        raise InputError(f"{path}: no valid scan: {findings.reason}")
    return findings.remarks()


def _per_scan(arrays: Mapping[str, npt.NDArray[Any]], key: str, count: int, path: Path) -> Floats | None:
    value = arrays.get(key)
    if value is None:
        return None
    if value.dtype.kind not in "fiu" or value.shape != (count,):
        raise InputError(f"{path}: '{key}' is {value.dtype} {value.shape}, which does not fit {count} scans")
    return np.asarray(value, dtype=np.float64)


def _stamps(stamps: Floats | None, count: int) -> tuple[Floats, list[str]]:
    if stamps is not None and np.all(np.isfinite(stamps)):
        return stamps, []
    what = "no stamps" if stamps is None else f"{int(np.sum(~np.isfinite(stamps)))} of {count} stamps are not finite"
    assumed = np.arange(count, dtype=np.float64) * (USUAL_PERIOD / 1e9)
    return assumed, [f"{what}: {USUAL_PERIOD / 1e6:g} ms between scans are assumed"]


def _whole(seconds: Floats) -> npt.NDArray[np.int64]:
    return np.asarray(np.round(seconds * 1e9), dtype=np.int64)


@dataclass(frozen=True)
class _Tables:
    """Tables of the file, with times on the recording's clock [s].

    origin: stamp of the first scan. offset: log time minus stamp [s]; None where it is not known.
    """

    arrays: Mapping[str, npt.NDArray[Any]]
    origin: float
    offset: float | None

    def read(self, key: str, *columns: str) -> Series | None:
        """The columns of a table that has stamps, or log times; None if it has not."""
        found, offset = _columns(self.arrays, key, ("stamp", *columns)), 0.0
        if found is None:
            found, offset = _columns(self.arrays, key, ("bag_stamp", *columns)), self.offset or 0.0
        return None if found is None else series(key, found[:, 0] - offset - self.origin, found[:, 1:])

    def commands(self) -> dict[str, Series]:
        """By table; the speed is NaN where a table has none."""
        found = {key: table for key in COMMANDS if (table := self.read(key, "speed", "steer")) is not None}
        for key in COMMANDS:
            turns = self.read(key, STEERING_ONLY)
            if turns is not None:
                unknown = np.full(len(turns.times), np.nan)
                found[key] = Series(key, turns.times, np.column_stack([unknown, turns.values]))
        return found


def _sources(tables: _Tables, times: Floats, wanted: Topics, path: Path) -> Sources:
    count = len(times)
    per_scan = {key: _per_scan(tables.arrays, key, count, path) for key in PER_SCAN}
    poses = None if wanted.odom == NONE else tables.read("odom", *POSE_COLUMNS)
    if poses is not None:
        poses.values[:, 2] = np.unwrap(poses.values[:, 2])
    twist = None if wanted.odom == NONE else tables.read("odom", "vx", "yaw_rate")
    speed, yaw_rate = per_scan["speed"], per_scan["yaw_rate"]
    if speed is not None:
        twist = series("speed", times, np.column_stack([speed, np.zeros(count) if yaw_rate is None else yaw_rate]))
    wheel = per_scan["steering_angle"] if per_scan["steering_angle"] is not None else per_scan["steer"]
    commands = tables.commands()
    if wanted.drive not in (None, NONE, *commands):
        raise InputError(f"{path}: --drive-topic {wanted.drive}: no such table of commands; available: "
                         f"{', '.join(commands) or 'none'}")  # fmt: skip
    return Sources(
        twist=twist,
        commands=commands.get(wanted.drive or next(iter(commands), NONE)),
        steering=None if wheel is None else series("steer", times, wheel),
        poses=poses,
    )


def _columns(arrays: Mapping[str, npt.NDArray[Any]], key: str, columns: tuple[str, ...]) -> Floats | None:
    """The columns of the table `key`; None if one is missing."""
    rows, names = arrays.get(key), str(arrays.get(f"{key}_columns", "")).split(",")
    if rows is None or rows.ndim != 2 or rows.dtype.kind not in "fiu" or rows.shape[1] != len(names) or not len(rows):
        return None
    if any(column not in names for column in columns):
        return None
    return np.asarray(rows[:, [names.index(column) for column in columns]], dtype=np.float64)


def _poses(arrays: Mapping[str, npt.NDArray[Any]], count: int, path: Path) -> Floats | None:
    poses = arrays.get("pose_global")
    if poses is None:
        return None
    if poses.shape != (count, 3) or poses.dtype.kind not in "fiu":
        raise InputError(f"{path}: 'pose_global' is {poses.dtype} {poses.shape}; expected ({count}, 3)")
    return np.asarray(poses, dtype=np.float64)
