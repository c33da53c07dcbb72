"""Interfaces of the sources of frames: a simulated race, a recording, a car over ROS 2."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable, Value
from firstlap.config.setup_file import Setup
from firstlap.pitwall.frame import Frame, Pose, Scenery


class Source(Protocol):
    """The interface of all sources. Thread-safe. Calls return immediately. Calls that change something raise InputError
    on failure, and then nothing has changed."""

    title: str
    """Display name: of the track, the recording or the car."""
    car: Car
    scenery: Scenery

    def start(self) -> None:
        """Starts a thread or process. Raises InputError if that fails."""

    def close(self) -> None:
        """Ends all threads and processes; a simulated car ends with them."""

    def latest(self) -> Frame | None:
        """The newest frame; None before the first. Never waits."""

    @property
    def setup(self) -> Setup:
        """The current setup."""

    @property
    def loaded(self) -> Setup:
        """The setup that "reset" restores."""

    def change(self, values: Mapping[str, Value]) -> None:
        """Changes parameters by section.name, while driving."""

    def choose(self, setup: Setup) -> None:
        """Loads a setup, possibly of another driver; it becomes `loaded`."""


@runtime_checkable
class Drives(Protocol):
    """A source with a car that moves."""

    def stop(self) -> None:
        """Emergency stop, immediately, until `go`. Never raises: failures are reported in the frames."""

    def go(self) -> None:
        """A person's consent to drive."""


@runtime_checkable
class Simulates(Protocol):
    """A source whose car and world can be changed."""

    conditions: FieldTable
    """Conditions of the simulated car and world: noise, friction, latency, pace."""

    def condition(self, name: str) -> Value:
        """The current value of a condition."""

    def set_condition(self, name: str, value: Value) -> None:
        """Changes a condition while driving."""

    def restart(self) -> None:
        """Restarts at the line, at rest, with an empty lap list."""

    def place(self, pose: Pose) -> None:
        """Places the car, at rest."""


@runtime_checkable
class Plays(Protocol):
    """A source that can be played and searched: a recording."""

    scans: int
    """Number of scans."""

    @property
    def scan(self) -> int:
        """The number of the current scan, from 0."""

    @property
    def playing(self) -> bool:
        """Whether it is playing."""

    def play(self) -> None:
        """Plays; from the start if it is at the end."""

    def pause(self) -> None:
        """Pauses."""

    def seek(self, scan: int) -> None:
        """Jumps to a scan, clamped to the valid range."""

    @property
    def pace(self) -> float:
        """Playback speed, as a multiple of real time."""

    def set_pace(self, pace: float) -> None:
        """Sets the playback speed."""
