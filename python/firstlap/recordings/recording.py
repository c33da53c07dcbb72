"""A recording, independent of its file format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.perception.scan import Mount
from firstlap.recordings.about import About

Floats = npt.NDArray[np.float64]

LONGEST_PAUSE = 0.5
"""[s] Maximum time between two scans; after a longer gap the planner is reset."""


@dataclass(frozen=True)
class Commands:
    """The recorded commands at each scan: (N,) m/s and rad, NaN if there was none."""

    topic: str
    speed: Floats
    steering_angle: Floats


@dataclass(frozen=True)
class Recording:
    """Scans in order of time with the measured state at each. SI units, base_link, left positive.

    ranges: N arrays of float32 [m]; their length may vary. Values that are not finite or outside of (range_min,
        range_max) are not returns.
    headers: (N, 5) angle_min, angle_increment [rad], time_increment [s], range_min, range_max [m]; the angles are for
        a LiDAR that points forward, independent of its mounting.
    start: time of the first scan's last beam [s], by the clock of the recording. stamps: (N,) [s] since then,
        increasing.
    dts: (N,) [s] since the previous scan.
    states: (N, 3) measured speed [m/s], yaw rate [rad/s], steering angle [rad].
    sources: the sources of "speed", "yaw_rate" and "steering_angle", or "none" if they are zero; and that of "laser",
        the LiDAR's mounting.
    poses: (N, 3) x, y, yaw of base_link in `frame`, or None. frame: "map", "odom" or the recording's name for it.
    odometry: (N, 3) x, y, yaw of base_link by odometry alone, if known in addition to poses in a map.
    laser: the LiDAR's mounting, if known; `headers` are already rotated by it.
    lateral_speed: (N,) [m/s] to the left, if in the odometry; no driver uses it.
    gyro: (N,) [rad/s] yaw rate of the IMU, if known; acceleration: (N, 2) [m/s^2] forward and left, likewise. NaN where
        the IMU has no message near.
    remarks: one line each on what was wrong, dropped or assumed.
    about: the metadata of our own logs.
    """

    name: str
    source: str
    ranges: Sequence[npt.NDArray[np.float32]]
    headers: Floats
    start: float
    stamps: Floats
    dts: Floats
    states: Floats
    sources: dict[str, str]
    commands: Commands | None = None
    poses: Floats | None = None
    frame: str = ""
    odometry: Floats | None = None
    laser: Mount | None = None
    lateral_speed: Floats | None = None
    gyro: Floats | None = None
    acceleration: Floats | None = None
    remarks: tuple[str, ...] = ()
    topics: dict[str, str] = field(default_factory=dict)
    about: About | None = None

    def __len__(self) -> int:
        return len(self.ranges)

    def scan(self, index: int) -> _core.LaserScan:
        """One scan, as drivers receive it."""
        return _core.LaserScan(
            np.ascontiguousarray(self.ranges[index], dtype=np.float32), *self.headers[index].tolist()
        )

    def state(self, index: int) -> _core.VehicleState:
        """The measured state at one scan."""
        return _core.VehicleState(*self.states[index].tolist())

    @property
    def duration(self) -> float:
        """[s] from the first scan to the last."""
        return float(self.stamps[-1] - self.stamps[0])

    @property
    def speed(self) -> Floats:
        """(N,) [m/s]"""
        return self.states[:, 0]

    @property
    def yaw_rate(self) -> Floats:
        """(N,) [rad/s]"""
        return self.states[:, 1]

    @property
    def steering_angle(self) -> Floats:
        """(N,) [rad]"""
        return self.states[:, 2]

    def between(self, begin: float | None, end: float | None) -> Recording:
        """The scans from `begin` to `end` seconds after the first. Raises InputError if there are none."""
        for name, value in (("--from", begin), ("--to", end)):
            if value is not None and math.isnan(value):
                raise InputError(f"{name} nan: expected seconds after the first scan")
        if begin is not None and end is not None and begin > end:
            raise InputError(f"--from {begin:g} is after --to {end:g}")
        first_scan = int(np.searchsorted(self.stamps, -np.inf if begin is None else begin - 1e-9))
        last_scan = int(np.searchsorted(self.stamps, np.inf if end is None else end + 1e-9))
        if first_scan >= last_scan:
            raise InputError(
                f"{self.source}: no scan between --from {0.0 if begin is None else begin:g} and "
                f"--to {self.duration if end is None else end:g}; it lasts {self.duration:.2f} s"
            )
        return self._part(slice(first_scan, last_scan))

    def first(self, count: int) -> Recording:
        """The first `count` scans."""
        return self._part(slice(0, count))

    def _part(self, part: slice) -> Recording:
        commands = self.commands
        return replace(
            self,
            ranges=self.ranges[part],
            headers=self.headers[part],
            stamps=self.stamps[part],
            dts=self.dts[part],
            states=self.states[part],
            commands=commands and Commands(commands.topic, commands.speed[part], commands.steering_angle[part]),
            poses=None if self.poses is None else self.poses[part],
            odometry=None if self.odometry is None else self.odometry[part],
            lateral_speed=None if self.lateral_speed is None else self.lateral_speed[part],
            gyro=None if self.gyro is None else self.gyro[part],
            acceleration=None if self.acceleration is None else self.acceleration[part],
        )
