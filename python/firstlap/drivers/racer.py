"""The Python interface of the method: numpy scan in, command out."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import LOCAL, Setup, choose_setup
from firstlap.perception.scan import USUAL_PERIOD


class Command(NamedTuple):
    """A command. steering_angle [rad], left positive; speed [m/s]; status: its reason."""

    speed: float
    steering_angle: float
    status: str


def step_core(core: _core.Driver, scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> Command:
    """One step of any core driver. dt: since the previous scan [s]."""
    return Command(*core.step(scan, state, dt))


class Racer:
    """The complete method with its memory: call `step` once per scan."""

    def __init__(self, setup: str | Setup | None = None, car: Car | None = None) -> None:
        """setup: a name, a file or a Setup; None: the default setup. car: its geometry and dynamics are used for
        `car.*` values that the setup does not set."""
        self.setup = choose_setup(LOCAL, setup)
        self.core = _core.Racer(self.setup.params(car.core if car else None))

    def step(
        self,
        ranges: npt.ArrayLike | _core.LaserScan,
        *,
        speed: float,
        yaw_rate: float = 0.0,
        steering_angle: float = 0.0,
        dt: float = USUAL_PERIOD,
        **header: float,
    ) -> Command:
        """One scan in, one command out. Does not raise for invalid data: the status gives the reason.

        ranges: (beams,) in meters; a contiguous float32 array is not copied. Values that are not finite or outside of
            (range_min, range_max) are not returns. Or a LaserScan, which has its header.
        speed, yaw_rate, steering_angle: measured, m/s, rad/s, rad, left positive.
        dt: seconds since the previous scan.
        header: of these ranges: angle_min, angle_increment [rad], time_increment [s], range_min, range_max [m].
            Default: 1081 beams over 270 degrees, simultaneous, 0.06 to 30 m.
        """
        if isinstance(ranges, _core.LaserScan):
            scan = ranges
        else:
            scan = _core.LaserScan(np.ascontiguousarray(ranges, dtype=np.float32).reshape(-1), **header)
        return step_core(self.core, scan, _core.VehicleState(speed, yaw_rate, steering_angle), dt)

    @property
    def trace(self) -> dict[str, Any]:
        """What the last step saw and thought: numpy arrays in base_link, meters (cpp/firstlap/drivers/trace.hpp)."""
        return self.core.trace()

    def reset(self) -> None:
        """Resets the memory."""
        self.core.reset()
