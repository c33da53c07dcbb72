"""A source without a car, for tests of the controls: parameters, conditions and requests."""

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
    """A source that records requests; its car never moves."""

    title = "standing"
    car: Car
    scenery = Scenery(centerline=np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]))

    def __init__(self) -> None:
        self.car = load_car("default")
        self.number = 0
        self._lock = threading.Lock()
        self.anew()

    def anew(self) -> None:
        """Resets to the loaded state."""
        self.driving = Driving(load_setup("base"))
        self.loaded_setup = self.driving.setup
        self.orders: list[object] = []
        self.changes: list[dict[str, Value]] = []
        self.may_drive = True

    def start(self) -> None:
        """Does nothing."""

    def close(self) -> None:
        """Does nothing."""

    def latest(self) -> Frame:
        """A new frame."""
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
        """The current setup."""
        return self.driving.setup

    @property
    def loaded(self) -> Setup:
        """The loaded setup."""
        return self.loaded_setup

    def change(self, values: Mapping[str, Value]) -> None:
        """As in a real source."""
        with self._lock:
            self.driving.change(values)
            self.changes.append(dict(values))

    def choose(self, setup: Setup) -> None:
        """As in a real source."""
        with self._lock:
            self.driving = Driving(setup)
            self.loaded_setup = setup


class StandingCar(Standing):
    """A source that drives and simulates."""

    conditions = FieldTable(row for row in _core.Car.fields() if row["section"] == "sensors")

    def anew(self) -> None:
        """Resets to the loaded state."""
        super().anew()
        self.values = {field.key: field.default for field in self.conditions.fields}

    def stop(self) -> None:
        """Counts the calls."""
        self.may_drive = False
        self.orders.append("stop")

    def go(self) -> None:
        """Counts the calls."""
        self.may_drive = True
        self.orders.append("go")

    def condition(self, name: str) -> Value:
        """The value of a condition."""
        return self.values[self.conditions.find(name, "conditions").key]

    def set_condition(self, name: str, value: Value) -> None:
        """Sets a condition, checked by the table."""
        field = self.conditions.find(name, "conditions")
        self.values[field.key] = self.conditions.check(field, value, "conditions")

    def restart(self) -> None:
        """Counts the calls."""
        self.orders.append("restart")

    def place(self, pose: Pose) -> None:
        """Counts the calls."""
        self.orders.append(pose)


class StandingTape(Standing):
    """A source that plays."""

    scans = 500

    def __init__(self) -> None:
        super().__init__()
        self.scan = 0
        self.playing = False
        self.pace = 1.0

    def play(self) -> None:
        """Sets the state to playing."""
        self.playing = True

    def pause(self) -> None:
        """Sets the state to paused."""
        self.playing = False

    def seek(self, scan: int) -> None:
        """Jumps to a scan, clamped to the valid range."""
        self.scan = min(max(scan, 0), self.scans - 1)

    def set_pace(self, pace: float) -> None:
        """Sets the playback speed."""
        self.pace = pace
