"""The measured state at each scan, from the available topics of a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from firstlap.config.car_file import CAR_FIELDS
from firstlap.recordings.recording import LONGEST_PAUSE, Commands

Floats = npt.NDArray[np.float64]


STEEPEST = 1.0
"""[rad] Maximum plausible steering angle; larger values are degrees, percent, or noise."""
NOISE = 0.01
"""Share of too large angles up to which they are noise; above, all angles are in another unit."""


@dataclass(frozen=True)
class Series:
    """Values over time: times (M,) [s] increasing, values (M, K)."""

    name: str
    times: Floats
    values: Floats

    def at(self, times: Floats) -> Floats:
        """(N, K) linearly interpolated, constant beyond the ends."""
        columns = [np.interp(times, self.times, column) for column in self.values.T]
        return np.column_stack(columns).reshape(len(times), self.values.shape[1])

    def near(self, times: Floats) -> npt.NDArray[np.bool_]:
        """(N,) whether there is a value within LONGEST_PAUSE."""
        after = np.clip(np.searchsorted(self.times, times), 0, len(self.times) - 1)
        before = np.maximum(after - 1, 0)
        distance = np.minimum(np.abs(self.times[after] - times), np.abs(self.times[before] - times))
        return np.asarray(distance <= LONGEST_PAUSE)

    def near_values(self, times: Floats) -> Floats:
        """(N, K) values at each of `times`, NaN where there is none near."""
        return np.where(self.near(times)[:, None], self.at(times), np.nan)


@dataclass(frozen=True)
class Sources:
    """The topics of a recording; each may be missing.

    twist: speed, yaw rate. lateral: speed to the left. turning: yaw rate of an IMU. acceleration: of the IMU, forward
    and left.
    commands: speed, steering angle. steering: steering angle.
    poses: x, y, yaw (unwrapped). imu_first: the IMU's yaw rate has priority.
    """

    twist: Series | None = None
    lateral: Series | None = None
    turning: Series | None = None
    acceleration: Series | None = None
    commands: Series | None = None
    steering: Series | None = None
    poses: Series | None = None
    imu_first: bool = False


@dataclass(frozen=True)
class States:
    """states (N, 3) and their sources, as in Recording."""

    states: Floats
    sources: dict[str, str]
    remarks: list[str]


def states_at(times: Floats, held: Sources, speed: float | None) -> States:
    """The state at each of `times`. speed [m/s]: used if the recording has none."""
    sources: dict[str, str] = {}
    remarks: list[str] = []
    columns = np.zeros((len(times), 3))
    twist, from_poses = held.twist, None
    if held.poses is not None and (twist is None or _stands(twist, held.poses)):
        twist, from_poses = motion_of(held.poses), held.poses.name
        remarks.append(f"speed and yaw rate were computed from the poses of {from_poses}")
    if twist is not None:
        columns[:, :2] = twist.at(times)
        sources.update(speed=f"odometry ({twist.name})", yaw_rate=f"odometry ({twist.name})")
        _note_missing(times, twist, "odometry", remarks)
    elif held.commands is not None and np.all(np.isfinite(held.commands.values[:, 0])):
        columns[:, 0] = held.commands.at(times)[:, 0]
        sources["speed"] = f"commands ({held.commands.name})"
        remarks.append(f"no odometry: the commanded speed is used, from {held.commands.name}")
    else:
        columns[:, 0] = 1.0 if speed is None else speed
        sources["speed"] = "none"
        remarks.append(f"neither odometry nor commands: a speed of {columns[0, 0]:g} m/s is assumed")
    if speed is not None and sources["speed"] != "none":
        remarks.append(f"the speed of {speed:g} m/s is not used: the recording has it, from {sources['speed']}")
    _add_steering(times, held, columns, sources)
    _add_yaw_rate(times, held, columns, sources, remarks)
    return States(columns, sources, remarks)


def _add_steering(times: Floats, held: Sources, columns: Floats, sources: dict[str, str]) -> None:
    sources["steering_angle"] = "none"
    if held.steering is not None and np.all(np.isfinite(held.steering.values)):
        columns[:, 2] = held.steering.at(times)[:, 0]
        sources["steering_angle"] = f"measured ({held.steering.name})"
    elif held.commands is not None and np.all(np.isfinite(held.commands.values[:, 1])):
        columns[:, 2] = held.commands.at(times)[:, 1]
        sources["steering_angle"] = f"commands ({held.commands.name})"


def _add_yaw_rate(times: Floats, held: Sources, columns: Floats, sources: dict[str, str], remarks: list[str]) -> None:
    turns = "yaw_rate" in sources and bool(np.any(columns[:, 1]))
    if held.imu_first and held.turning is None:
        remarks.append("the IMU of --imu-topic measures no yaw rate: another source is used")
    if held.turning is not None and (held.imu_first or not turns):
        columns[:, 1] = held.turning.at(times)[:, 0]
        sources["yaw_rate"] = f"imu ({held.turning.name})"
        _note_missing(times, held.turning, "imu", remarks)
    elif not turns and sources["steering_angle"] != "none":
        wheelbase = float(CAR_FIELDS.find("geometry.wheelbase", "car").default)
        columns[:, 1] = columns[:, 0] * np.tan(np.clip(columns[:, 2], -1.0, 1.0)) / wheelbase
        sources["yaw_rate"] = f"steering angle, {sources['steering_angle']}"
        remarks.append(f"no yaw rate: it was computed from speed and steering angle, wheelbase {wheelbase:g} m")
    elif not turns:
        sources["yaw_rate"] = sources.get("yaw_rate", "none")


def _note_missing(times: Floats, series: Series, what: str, remarks: list[str]) -> None:
    lost = int(np.count_nonzero(~series.near(times)))
    if lost:
        remarks.append(f"{lost} scans have no {what} within {LONGEST_PAUSE:g} s: the last value is used")


def _stands(twist: Series, poses: Series) -> bool:
    """Whether the twist is always zero although the car moved."""
    return not np.any(twist.values) and bool(np.ptp(poses.values[:, :2], axis=0).max() > 0.5)


def motion_of(poses: Series) -> Series:
    """Speed along the car [m/s] and yaw rate [rad/s] from its poses, over about a tenth of a second."""
    times, values = poses.times, poses.values
    before = np.maximum(np.searchsorted(times, times - 0.05) - 1, 0)
    after = np.minimum(np.searchsorted(times, times + 0.05), len(times) - 1)
    step = np.maximum(times[after] - times[before], 1e-6)
    moved = values[after] - values[before]
    yaw = values[:, 2]
    speed = (moved[:, 0] * np.cos(yaw) + moved[:, 1] * np.sin(yaw)) / step
    return Series(poses.name, times, np.column_stack([speed, moved[:, 2] / step]))


def in_radians(series: Series | None, column: int, remarks: list[str]) -> Series | None:
    """The series without implausible steering angles: all become NaN if they are in another unit, else the affected
    rows are dropped. `column`: of the angles [rad]."""
    if series is None:
        return None
    angles = series.values[:, column]
    wrong = np.abs(angles) > STEEPEST
    count = int(np.count_nonzero(wrong))
    if not count:
        return series
    said = f"{count} of {len(wrong)} steering angles of {series.name} are above {STEEPEST:g} rad"
    if count <= NOISE * len(wrong):
        remarks.append(f"{said}: these were dropped")
        return Series(series.name, series.times[~wrong], series.values[~wrong])
    remarks.append(
        f"{said}, the largest {np.abs(angles).max():.3g}: degrees or percent instead of radians; all were dropped"
    )
    values = series.values.copy()
    values[:, column] = np.nan
    return Series(series.name, series.times, values)


def commands_at(times: Floats, commands: Series | None) -> Commands | None:
    """The recorded commands at each scan, NaN if there is none near."""
    if commands is None:
        return None
    values = commands.near_values(times)
    return Commands(commands.name, np.ascontiguousarray(values[:, 0]), np.ascontiguousarray(values[:, 1]))


def series(name: str, times: Floats, values: Floats) -> Series | None:
    """A series sorted by time, without repeated times and values that are not finite; None if it is empty."""
    values = np.asarray(values, dtype=np.float64).reshape(len(times), -1)
    good = np.isfinite(times) & np.all(np.isfinite(values), axis=1)
    times, values = np.asarray(times, dtype=np.float64)[good], values[good]
    order = np.argsort(times, kind="stable")
    times, values = times[order], values[order]
    once = np.concatenate([np.diff(times) > 0, [True]])[: len(times)]
    return Series(name, times[once], values[once]) if np.any(once) else None
