"""The Python interface of the method: numpy scan in, command out."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.perception.scan import USUAL_PERIOD


class Command(NamedTuple):
    """A command. steering_angle [rad], left positive; speed [m/s]; status: its reason."""

    speed: float
    steering_angle: float
    status: str


def step_core(
    core: _core.Driver,
    ranges: npt.ArrayLike,
    *,
    speed: float,
    yaw_rate: float = 0.0,
    steering_angle: float = 0.0,
    dt: float = USUAL_PERIOD,
    angle_min: float = -0.75 * math.pi,
    angle_increment: float = math.pi / 720.0,
    time_increment: float = 0.0,
    range_min: float = 0.06,
    range_max: float = 30.0,
) -> Command:
    """One step of any core driver; arguments as for `Racer.step`."""
    scan = np.ascontiguousarray(ranges, dtype=np.float32).reshape(-1)
    header = (angle_min, angle_increment, time_increment, range_min, range_max)
    return Command(*core.step(scan, speed, yaw_rate, steering_angle, dt, *header))


class Racer:
    """The complete method with its memory: call `step` once per scan."""

    def __init__(self, setup: str | Setup = "sure", car: Car | None = None) -> None:
        """setup: a name, a file or a Setup. car: its geometry is used for `car.*` values that the setup does not
        set."""
        self.setup = choose_setup("local", setup)
        self.core = _core.Racer(self.setup.params(car.core if car else None))

    def step(
        self,
        ranges: npt.ArrayLike,
        *,
        speed: float,
        yaw_rate: float = 0.0,
        steering_angle: float = 0.0,
        dt: float = USUAL_PERIOD,
        angle_min: float = -0.75 * math.pi,
        angle_increment: float = math.pi / 720.0,
        time_increment: float = 0.0,
        range_min: float = 0.06,
        range_max: float = 30.0,
    ) -> Command:
        """One scan in, one command out. Does not raise for invalid data: the status gives the reason.

        ranges: (beams,) in meters; a contiguous float32 array is not copied. Values that are not finite or outside of
            (range_min, range_max) are not returns.
        speed, yaw_rate, steering_angle: measured, m/s, rad/s, rad, left positive.
        dt: seconds since the previous scan.
        angle_min, angle_increment: of the first beam and between beams, rad; default: 1081 beams over 270 degrees.
        time_increment: seconds between beams; 0 if all are simultaneous.
        """
        return step_core(
            self.core,
            ranges,
            speed=speed,
            yaw_rate=yaw_rate,
            steering_angle=steering_angle,
            dt=dt,
            angle_min=angle_min,
            angle_increment=angle_increment,
            time_increment=time_increment,
            range_min=range_min,
            range_max=range_max,
        )

    @property
    def trace(self) -> dict[str, Any]:
        """What the last step saw and thought: numpy arrays in base_link, meters (cpp/firstlap/drivers/trace.hpp)."""
        return self.core.trace()

    def reset(self) -> None:
        """Resets the memory."""
        self.core.reset()
