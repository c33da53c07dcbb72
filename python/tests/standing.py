"""A source that stands: parameters, conditions and orders without a car, for the tests of the controls."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car, load_car
from firstlap.config.parameters import FieldTable, Value
from firstlap.config.setup_file import Setup, load_setup
from firstlap.drivers.driving import Driving
from firstlap.pitwall.frame import Frame, Pose, Scenery


class Standing:
    """Of a car that does as it is told and goes nowhere."""

    title = "standing"
    car: Car
    scenery = Scenery(centerline=np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]))

    def __init__(self) -> None:
        self.car = load_car("default")
        self.number = 0
        self._lock = threading.Lock()
        self.anew()

    def anew(self) -> None:
        """As it was loaded."""
        self.driving = Driving(load_setup("base"))
        self.loaded_setup = self.driving.setup
        self.orders: list[object] = []
        self.changes: list[dict[str, Value]] = []
        self.may_drive = True

    def start(self) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""

    def latest(self) -> Frame:
        """The next one."""
        self.number += 1
        return Frame(
            self.number,
            0.025 * self.number,
            (0.0, 0.0, 0.0),
            0.0,
            0.0,
            0.0,
            self.setup.driver,
            {},
            1.0,
            may_drive=self.may_drive,
        )

    @property
    def setup(self) -> Setup:
        """What drives."""
        return self.driving.setup

    @property
    def loaded(self) -> Setup:
        """What was loaded."""
        return self.loaded_setup

    def change(self, values: Mapping[str, Value]) -> None:
        """As a real one."""
        with self._lock:
            self.driving.change(values)
            self.changes.append(dict(values))

    def choose(self, setup: Setup) -> None:
        """As a real one."""
        with self._lock:
            self.driving = Driving(setup)
            self.loaded_setup = setup


class StandingCar(Standing):
    """That is driven and simulated."""

    conditions = FieldTable(row for row in _core.Car.fields() if row["section"] == "sensors")

    def anew(self) -> None:
        """As it was loaded."""
        super().anew()
        self.values = {field.key: field.default for field in self.conditions.fields}

    def stop(self) -> None:
        """Counted."""
        self.may_drive = False
        self.orders.append("stop")

    def go(self) -> None:
        """Counted."""
        self.may_drive = True
        self.orders.append("go")

    def condition(self, name: str) -> Value:
        """One of them."""
        return self.values[self.conditions.find(name, "conditions").key]

    def set_condition(self, name: str, value: Value) -> None:
        """Checked against the table."""
        field = self.conditions.find(name, "conditions")
        self.values[field.key] = self.conditions.check(field, value, "conditions")

    def restart(self) -> None:
        """Counted."""
        self.orders.append("restart")

    def place(self, pose: Pose) -> None:
        """Counted."""
        self.orders.append(pose)


class StandingTape(Standing):
    """That is wound."""

    scans = 500

    def __init__(self) -> None:
        super().__init__()
        self.scan = 0
        self.playing = False
        self.pace = 1.0

    def play(self) -> None:
        """Runs, in principle."""
        self.playing = True

    def pause(self) -> None:
        """Stands."""
        self.playing = False

    def seek(self, scan: int) -> None:
        """Within what there is."""
        self.scan = min(max(scan, 0), self.scans - 1)

    def set_pace(self, pace: float) -> None:
        """Times real time."""
        self.pace = pace
