"""The method from Python: a numpy scan in, a command out."""

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
    """What the car is asked for. steering_angle [rad], left positive; speed [m/s]; status: why."""

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
    """One step of any driver of the core; arguments as of `Racer.step`."""
    scan = np.ascontiguousarray(ranges, dtype=np.float32).reshape(-1)
    header = (angle_min, angle_increment, time_increment, range_min, range_max)
    return Command(*core.step(scan, speed, yaw_rate, steering_angle, dt, *header))


class Racer:
    """The whole method with its memory: call `step` once per scan."""

    def __init__(self, setup: str | Setup = "sure", car: Car | None = None) -> None:
        """setup: a name, a file or a Setup. car: its body replaces what the setup does not say itself."""
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
        """One scan in, one command out. Never raises for bad data: the status says what was wrong.

        ranges: (beams,) in meters; a contiguous float32 array is not copied. What is not finite or outside of
            (range_min, range_max) is no return.
        speed, yaw_rate, steering_angle: measured, m/s, rad/s, rad, left positive.
        dt: seconds since the scan before.
        angle_min, angle_increment: of the first beam and between beams, rad; default: 1081 beams over 270 degrees.
        time_increment: seconds between beams; 0 when all belong to one moment.
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
        """Forgets everything that was seen."""
        self.core.reset()
