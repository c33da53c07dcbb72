"""How the car moved, from its scans alone: steps that odometry can be held against."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.estimation.odometry_check import Steps
from firstlap.perception.scan import Mount, Scan, set_laser
from firstlap.tracks.track import FloatArray

FIT = 0.6
"""Share of the points that must lie on the scan before."""
TELLS_ALONG = 0.02
"""Share of the points that must tell how far the car went; a bare corridor has fewer."""
COMMAND_HOLDS = 0.5
"""[s] after which a command says nothing any more."""


class ScanStep(NamedTuple):
    """One step. begin, end: [s]. forward, left [m], turn [rad]: of base_link at the end as seen from the begin.

    fit: share of the points that lie on the walls of the scan before. along: share of them that tells `forward`.
    """

    begin: float
    end: float
    forward: float
    left: float
    turn: float
    fit: float
    along: float

    @property
    def fits(self) -> bool:
        """Whether the scans lie on each other at all."""
        return self.fit >= FIT

    @property
    def tells_along(self) -> bool:
        """Whether the walls say how far the car went."""
        return self.fits and self.along >= TELLS_ALONG


class ScanMotion:
    """Scans in the order of time, steps out."""

    def __init__(self, car: Car) -> None:
        self._core = _core.ScanMotion(_core.MapParams(), car.core)

    @classmethod
    def at(cls, mount: Mount) -> ScanMotion:
        """Of a laser that sits there."""
        core = _core.Car.preset("default")
        set_laser(core, mount.x, mount.y)
        return cls(Car("", core))

    def add(self, scan: Scan, time: float) -> ScanStep | None:
        """The step that this scan ends. time: [s] of its last beam. None until there is something to tell."""
        found: Any = self._core.add(
            scan.ranges,
            time,
            scan.angle_min,
            scan.angle_increment,
            scan.time_increment,
            scan.range_min,
            scan.range_max,
        )
        return None if found is None else ScanStep(*found)

    def forget(self) -> None:
        """As if no scan had come."""
        self._core.forget()


def as_steps(found: Sequence[ScanStep], times: FloatArray, speeds: FloatArray) -> Steps:
    """The steps for a judgment of odometry. times (M,) [s], speeds (M,) [m/s]: what was commanded, if anything was."""
    rows = np.array(found, dtype=np.float64).reshape(-1, len(ScanStep._fields))
    motion = rows[:, 2:5].copy()
    motion[[not step.fits for step in found]] = np.nan
    motion[[not step.tells_along for step in found], 0] = np.nan
    return Steps(rows[:, 0], rows[:, 1], motion, _commanded(rows[:, 1], times, speeds))


def _commanded(when: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    """(K,) the last command before each time, NaN where there is none."""
    if not len(times):
        return np.full(len(when), np.nan)
    before = np.searchsorted(times, when, side="right") - 1
    last = np.maximum(before, 0)
    holds = (before >= 0) & (when - times[last] <= COMMAND_HOLDS)
    return np.where(holds, speeds[last], np.nan)
