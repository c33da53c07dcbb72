"""Races in separate processes, for drivers in Python, which would otherwise wait for each other's GIL."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from typing import Any

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.sim.race import RaceResult, race
from firstlap.tracks.track import Track

STAYS = ("track", "setup", "car")
"""Fields of a result that the caller knows and that are not sent back."""


class InterruptedRaceError(Exception):
    """The races were interrupted."""


class RacePool(ProcessPoolExecutor):
    """Processes that race. Set `stop` to end their races; they ignore Ctrl-C, which this process handles."""

    def __init__(self, jobs: int, begin: Callable[[], object] | None = None) -> None:
        """begin: called in each process before its first race."""
        context = multiprocessing.get_context("spawn")
        self.stop = context.Event()
        super().__init__(jobs, context, _begin, (self.stop, begin))


_stop: Any = None


def _begin(stop: Any, begin: Callable[[], object] | None) -> None:
    global _stop
    if begin:
        begin()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stop = stop


PackedCar = tuple[str, dict[str, dict[str, float]]]


def packed(car: Car) -> PackedCar:
    """The car in a picklable form."""
    return car.name, car.core.values()


def unpacked(car: PackedCar) -> Car:
    """The inverse of `packed`."""
    name, values = car
    core = _core.Car()
    for section, content in values.items():
        for field, value in content.items():
            core.set(section, field, value)
    return Car(name, core)


def race_in_process(track: Track, setup: Setup, car: PackedCar, options: dict[str, Any]) -> dict[str, Any]:
    """Races in a process of a `RacePool`; `restored` makes the result. options: further arguments of `race`."""
    result = race(track, setup, unpacked(car), on_progress=_check_stop, **options)
    return {field.name: getattr(result, field.name) for field in fields(result) if field.name not in STAYS}


def _check_stop(_running: object) -> None:
    if _stop is not None and _stop.is_set():
        raise InterruptedRaceError


def bare(track: Track) -> Track:
    """The track without its cached properties, to send less."""
    return replace(track)


def restored(found: dict[str, Any], track: Track, setup: Setup, car: Car) -> RaceResult:
    """The result of `race_in_process`, with the fields that were not sent. track: in its direction of travel."""
    return RaceResult(track=track, setup=setup, car=car, **found)
