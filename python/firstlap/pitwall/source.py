"""Where frames come from, and what may be asked of it: a simulated race, a recording, a car over ROS 2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable, Value
from firstlap.config.setup_file import Setup
from firstlap.pitwall.frame import Frame, Pose, Scenery


class Source(Protocol):
    """What every source can do. All calls return at once; those that change something raise InputError with what was
    wrong, and then nothing has changed. Any thread may call."""

    title: str
    """For people: the track, the recording, the car."""
    car: Car
    scenery: Scenery

    def start(self) -> None:
        """Begins, in a thread or process of its own. Raises InputError where it cannot."""

    def close(self) -> None:
        """Ends and leaves nothing running; a car that it drives or could drive is left stopped."""

    def latest(self) -> Frame | None:
        """The newest frame; None before the first. Never waits."""

    @property
    def setup(self) -> Setup:
        """What drives now."""

    @property
    def loaded(self) -> Setup:
        """What "reset" goes back to."""

    def change(self, values: Mapping[str, Value]) -> None:
        """Parameters by section.name, while driving."""

    def choose(self, setup: Setup) -> None:
        """Another setup, maybe of another driver; it becomes `loaded`."""


@runtime_checkable
class Drives(Protocol):
    """A source with a car that moves."""

    def stop(self) -> None:
        """Emergency stop: at once, until `go`. Never raises: what cannot be reached is said in the frames."""

    def go(self) -> None:
        """A person's consent to drive on."""


@runtime_checkable
class Simulates(Protocol):
    """A source whose car and world can be changed."""

    conditions: FieldTable
    """What may be changed of the simulated car and its world: noise, friction, latency, pace."""

    def condition(self, name: str) -> Value:
        """One of them now."""

    def set_condition(self, name: str, value: Value) -> None:
        """Changes one while driving."""

    def restart(self) -> None:
        """Back to the line, at rest; laps begin anew."""

    def place(self, pose: Pose) -> None:
        """The car stands there, at rest."""


@runtime_checkable
class Plays(Protocol):
    """A source that can be wound: a recording."""

    scans: int
    """How many."""

    @property
    def scan(self) -> int:
        """The one that is shown, from 0."""

    @property
    def playing(self) -> bool:
        """Whether it runs by itself."""

    def play(self) -> None:
        """Runs on; from the start, where it stood at its end."""

    def pause(self) -> None:
        """Stands."""

    def seek(self, scan: int) -> None:
        """To that scan, kept within what there is."""

    @property
    def pace(self) -> float:
        """Times real time."""

    def set_pace(self, pace: float) -> None:
        """Times real time."""
