"""A driver whose parameters can change while it drives, with scans from a LiDAR of any mounting."""

from __future__ import annotations

from collections.abc import Mapping

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS, Car
from firstlap.config.driver_kind import Handle, Preparation, driver_kind
from firstlap.config.parameters import Field, Value
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.drivers.racer import Command, step_core
from firstlap.perception.scan import LASER, Mount


class Driving:
    """setup: as for `firstlap race`. car: its geometry is used for `car.*` values that the setup does not set.
    preparation: of a driver that needs a map; such a driver is reset by every change. Raises InputError."""

    def __init__(self, setup: Setup, car: Car | None = None, preparation: Preparation | None = None) -> None:
        self.setup = setup
        self.car = car
        self.preparation = preparation or Preparation()
        self.kind = driver_kind(setup.driver)
        if self.kind.needs_map and preparation is None:
            raise InputError(f"driver {self.kind.name} needs a map of the track and cannot be used without one")
        self.laser: tuple[float, float] | None = None
        self.handle = self._new()

    @staticmethod
    def of(driver: str, setup: str) -> Driving:
        """Makes it from names, either of which may be empty. Raises InputError."""
        return Driving(choose_setup(driver or None, setup or None))

    @property
    def fields(self) -> list[Field]:
        """The field table of the driver."""
        return self.kind.fields.fields

    @property
    def steering_limit(self) -> float:
        """Maximum steering angle [rad]."""
        has = "car" in self.kind.fields.sections
        return float(self.setup.get("car.steering_limit") if has else CAR_FIELDS.find("steering_limit", "car").default)

    @property
    def laser_given(self) -> tuple[float, float]:
        """x, y [m] of the LiDAR in the setup; (0, 0) if its driver has no car parameters."""
        if "car" not in self.kind.fields.sections:
            return 0.0, 0.0
        x, y = (float(self.setup.get(f"car.{name}")) for name in LASER)
        return x, y

    def change(self, values: Mapping[str, Value]) -> None:
        """Changes parameters while driving. Raises InputError without changing anything."""
        self.take(self.setup.with_values(values))

    def take(self, setup: Setup) -> None:
        """Changes the setup while driving, for the same driver. Raises InputError without changing anything."""
        before, self.setup = self.setup, setup
        try:
            self._apply()
        except (InputError, ValueError) as error:
            self.setup = before
            raise InputError(str(error)) from None

    def mount(self, mount: Mount) -> None:
        """Sets the LiDAR's mounting. Raises InputError if it is out of range."""
        if "car" in self.kind.fields.sections:
            for name, value in zip(LASER, (mount.x, mount.y), strict=True):
                self.kind.fields.check(self.kind.fields.find(f"car.{name}", "laser"), value, "laser")
        self.laser = (mount.x, mount.y)
        self._apply()

    def step(self, scan: _core.LaserScan, speed: float, yaw_rate: float, steering_angle: float, dt: float) -> Command:
        """One command; see `Racer.step`."""
        return step_core(self.handle.core, scan, _core.VehicleState(speed, yaw_rate, steering_angle), dt)

    def reset(self) -> None:
        """Resets the driver's memory."""
        self.handle.core.reset()

    def _apply(self) -> None:
        if isinstance(self.handle.core, _core.Racer):
            self.handle.core.set_params(self._params())
        else:
            self.handle = self._new()

    def _new(self) -> Handle:
        return self.kind.make(self._params(), self.car, self.preparation)

    def _params(self) -> _core.Params:
        params = self.setup.params(self.car.core if self.car else None)
        if self.laser is not None and "car" in self.kind.fields.sections:
            for name, value in zip(LASER, self.laser, strict=True):
                params.set("car", name, value)
        return params
