"""The particle filter from Python: a scan and odometry in, a pose on the map out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable
from firstlap.mapping.occupancy_map import OccupancyMap

LOCALIZER_FIELDS = FieldTable(_core.LocalizerParams.fields())


class ScanHeader(NamedTuple):
    """What belongs to the ranges of a scan, as in sensor_msgs/LaserScan: rad, s, m."""

    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float


class Estimate(NamedTuple):
    """base_link in the map's frame at the end of the sweep: x, y [m], yaw [rad].

    std [m], std_yaw [rad]: spread of the particles round it. fit: share of the scan that lies on the map.
    searching: something does not fit, the filter looks further round. lost: do not trust the pose; stop.
    speed_scale: true speed per measured, by how far the car came on the map; command_scale: true speed per commanded,
    never below 1. Both are exactly 1 where nothing speaks clearly against what is measured.
    """

    x: float
    y: float
    yaw: float
    std: float
    std_yaw: float
    fit: float
    searching: bool
    lost: bool
    speed_scale: float = 1.0
    command_scale: float = 1.0


def localizer_params(assignments: list[str] | None = None) -> _core.LocalizerParams:
    """The defaults with changes such as "filter.particles_max=2000". Raises InputError."""
    params = _core.LocalizerParams()
    for text in assignments or []:
        field, value = LOCALIZER_FIELDS.parse_assignment(text)
        params.set(field.section, field.name, value)
    try:
        params.validate()
    except ValueError as error:
        raise InputError(f"--set: {error}") from None
    return params


class Localizer:
    """Follows a car on a map: `start` once, then `step` for each scan. The same seed gives the same poses."""

    def __init__(
        self, known: OccupancyMap, car: Car, seed: int = 1, params: _core.LocalizerParams | None = None
    ) -> None:
        """Raises InputError for a map without walls."""
        self.core = _core.Localizer(known.field(), car.core, params or _core.LocalizerParams(), seed)

    def start(self, pose: tuple[float, float, float]) -> Localizer:
        """base_link is about at (x, y, yaw), see filter.start_radius and start_angle. Returns itself."""
        self.core.start(*pose)
        return self

    def step(
        self,
        ranges: npt.NDArray[np.float32],
        speed: float,
        yaw_rate: float,
        steering_angle: float,
        dt: float,
        header: ScanHeader,
    ) -> Estimate:
        """One scan in, one pose out, without the GIL. Never raises for bad data; the estimate says lost.

        ranges: (beams,) float32, contiguous, not copied. speed, yaw_rate, steering_angle: measured at the end of the
        sweep, m/s, rad/s, rad. dt: seconds since the scan before.
        """
        return Estimate(*self.core.step(ranges, speed, yaw_rate, steering_angle, dt, *header))

    def commanded(self, speed: float) -> None:
        """The speed command [m/s] that was given after the last step: without it `command_scale` stays 1."""
        self.core.commanded(speed)

    def predict(self, at: Estimate, speed: float, yaw_rate: float, time: float) -> tuple[float, float, float]:
        """The pose `time` seconds after the estimate: where a command meets the car that computing has delayed."""
        x, y, yaw = self.core.predict(at.x, at.y, at.yaw, speed, yaw_rate, time)
        return x, y, yaw
