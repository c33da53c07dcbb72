"""A race as a source of frames for drawing tests, stepped explicitly or in a thread."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car, load_car
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.drivers.driving import Driving
from firstlap.drivers.racer import step_core
from firstlap.pitwall.frame import DrivenLap, Frame, Scenery
from firstlap.sim.lidar import core_track
from firstlap.tracks.track import Track


def scenery_of(track: Track) -> Scenery:
    """The scenery of a known track."""
    return Scenery(tuple(track.walls), tuple(track.visible), track.centerline)


def some_lap(number: int, time: float, *, standing: bool = False) -> DrivenLap:
    """A lap around a circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    line = 3.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    return DrivenLap(number, time, line, np.full(50, 2.5), 0.3, standing)


class Racing:
    """One car on a track."""

    car: Car

    def __init__(self, track: Track, driver: str = "local") -> None:
        self.title = track.name
        self.car = load_car("default")
        self.scenery = scenery_of(track)
        self.driving = Driving(choose_setup(driver, None))
        self.world = _core.World(core_track(track), self.car.core, _core.WorldOptions(), 1)
        self._frame: Frame | None = None
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run)

    @property
    def setup(self) -> Setup:
        """The current setup."""
        return self.driving.setup

    loaded = setup

    def start(self) -> None:
        """Steps in real time, in a thread."""
        self._thread.start()

    def close(self) -> None:
        """Ends the thread."""
        self._done.set()
        self._thread.join()

    def latest(self) -> Frame | None:
        """The newest frame."""
        return self._frame

    def change(self, values: Mapping[str, Value]) -> None:
        """Does nothing."""

    def choose(self, setup: Setup) -> None:
        """Does nothing."""

    def step(self) -> Frame:
        """Advances by one scan."""
        self.world.advance()
        state = self.world.measured(0)
        command = step_core(self.driving.handle.core, self.world.scan(0), state, self.world.period)
        self.world.command(0, command[0], command[1])
        at = self.world.truth(0)
        self._frame = Frame(
            number=1 if self._frame is None else self._frame.number + 1,
            time=self.world.time,
            pose=(at["x"], at["y"], at["yaw"]),
            speed=state.speed,
            yaw_rate=state.yaw_rate,
            steering_angle=state.steering_angle,
            driver=self.driving.kind.name,
            trace=self.driving.handle.trace,
            step_us=100.0,
            distance=at["s"],
            clearance=self.world.clearance(0),
        )
        return self._frame

    def _run(self) -> None:
        while not self._done.wait(self.world.period):
            self.step()
