"""A recording as the rest of firstlap sees it, wherever it came from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.perception.scan import Mount, Scan
from firstlap.recordings.about import About

Floats = npt.NDArray[np.float64]

LONGEST_PAUSE = 0.5
"""[s] between two scans; after more, the recording has a gap and the planner begins anew."""


@dataclass(frozen=True)
class Commands:
    """What drove the car while it was recorded, at each scan. (N,) m/s and rad, NaN where there was none."""

    topic: str
    speed: Floats
    steering_angle: Floats


@dataclass(frozen=True)
class Recording:
    """Scans in the order of time with all that is known at each. SI units, base_link, left positive.

    ranges: N arrays of float32 [m]; their length may change from scan to scan. What is not finite or outside of
        (range_min, range_max) is no return.
    headers: (N, 5) angle_min, angle_increment [rad], time_increment [s], range_min, range_max [m]; the angles as of a
        laser that looks ahead, whatever its mounting.
    start: [s] of the first scan's last ray, by the clock of the recording. stamps: (N,) [s] of each since then,
        increasing.
    dts: (N,) [s] since the scan before.
    states: (N, 3) measured speed [m/s], yaw rate [rad/s], wheel angle [rad].
    sources: of "speed", "yaw_rate" and "steering_angle": what they were taken from, or "none" where they are zero; of
        "laser": who said where it is mounted.
    poses: (N, 3) x, y, yaw of base_link in `frame`, or None. frame: "map", "odom" or what the recording calls it.
    odometry: (N, 3) x, y, yaw of base_link by odometry alone, where it is known beside poses in a map.
    laser: where it is mounted, where the recording or a person says it; `headers` are turned by it already.
    lateral_speed: (N,) [m/s] to the left, where the odometry says it; no driver uses it.
    remarks: one line each: what was wrong, dropped or assumed.
    about: for a log of ours, what it says of itself.
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
    remarks: tuple[str, ...] = ()
    topics: dict[str, str] = field(default_factory=dict)
    about: About | None = None

    def __len__(self) -> int:
        return len(self.ranges)

    def scan(self, index: int) -> Scan:
        """One of them, as drivers take it."""
        return Scan(np.ascontiguousarray(self.ranges[index], dtype=np.float32), *self.headers[index].tolist())

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
        """The scans from `begin` to `end` seconds after the first. Raises InputError where there are none."""
        for name, value in (("--from", begin), ("--to", end)):
            if value is not None and math.isnan(value):
                raise InputError(f"{name} nan: expected seconds after the first scan")
        if begin is not None and end is not None and begin > end:
            raise InputError(f"--from {begin:g} is after --to {end:g}")
        first_scan = int(np.searchsorted(self.stamps, -np.inf if begin is None else begin - 1e-9))
        last_scan = int(np.searchsorted(self.stamps, np.inf if end is None else end + 1e-9))
        if first_scan >= last_scan:
            raise InputError(
                f"{self.source}: has no scan between --from {0.0 if begin is None else begin:g} and "
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
        )
