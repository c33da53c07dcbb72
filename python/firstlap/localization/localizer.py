"""The Python interface of the particle filter: scan and odometry in, pose in the map out."""

from __future__ import annotations

from firstlap import _core
from firstlap._core import Estimate
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable
from firstlap.mapping.occupancy_map import OccupancyMap

LOCALIZER_FIELDS = FieldTable(_core.LocalizerParams.fields())


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
    """Localizes a car on a map: `start` once, then `step` for each scan. The same seed gives the same poses."""

    def __init__(
        self, known: OccupancyMap, car: Car, seed: int = 1, params: _core.LocalizerParams | None = None
    ) -> None:
        """Raises InputError for a map without walls."""
        self.core = _core.Localizer(known.field(), car.core, params or _core.LocalizerParams(), seed)

    def start(self, pose: tuple[float, float, float]) -> Localizer:
        """Sets the approximate pose (x, y, yaw) of base_link, see filter.start_radius and start_angle. Returns self."""
        self.core.start(*pose)
        return self

    def step(self, scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> Estimate:
        """Estimates the pose from one scan; releases the GIL. Does not raise for invalid data; the estimate is lost.

        state: measured at the end of the sweep. dt: seconds since the previous scan.
        """
        return self.core.step(scan, state, dt)

    def commanded(self, speed: float) -> None:
        """Sets the speed command [m/s] given after the last step; without it `command_scale` stays 1."""
        self.core.commanded(speed)

    def predict(self, at: Estimate, state: _core.VehicleState, time: float) -> tuple[float, float, float]:
        """The predicted pose `time` seconds after the estimate, to compensate for latency."""
        x, y, yaw = self.core.predict((at.x, at.y, at.yaw), state, time)
        return x, y, yaw
