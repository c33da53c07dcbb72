"""The car's motion from its scans alone, as a reference for odometry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.estimation.odometry_check import Steps
from firstlap.perception.scan import Mount, set_laser
from firstlap.tracks.track import FloatArray

FIT = 0.6
"""Share of the points that must match the previous scan."""
TELLS_ALONG = 0.02
"""Share of the points that must constrain the forward motion; a bare corridor has fewer."""
COMMAND_HOLDS = 0.5
"""[s] Age after which a command is ignored."""


class ScanStep(NamedTuple):
    """One step. begin, end: [s]. forward, left [m], turn [rad]: motion of base_link in its frame at the beginning.

    fit: share of the points that match the previous scan. along: share of them that constrains `forward`.
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
        """Whether the scans match."""
        return self.fit >= FIT

    @property
    def tells_along(self) -> bool:
        """Whether the walls constrain the forward motion."""
        return self.fits and self.along >= TELLS_ALONG


class ScanMotion:
    """Estimates the steps between consecutive scans."""

    def __init__(self, car: Car) -> None:
        self._core = _core.ScanMotion(_core.MapParams(), car.core)

    @classmethod
    def at(cls, mount: Mount) -> ScanMotion:
        """An estimator for a LiDAR at that mounting."""
        core = _core.Car.preset("default")
        set_laser(core, mount.x, mount.y)
        return cls(Car("", core))

    def add(self, scan: _core.LaserScan, time: float) -> ScanStep | None:
        """The step that ends with this scan; None for the first one. time: of its last beam [s]."""
        found: Any = self._core.add(scan, time)
        return None if found is None else ScanStep(*found)

    def forget(self) -> None:
        """Discards all scans."""
        self._core.forget()


def as_steps(found: Sequence[ScanStep], times: FloatArray, speeds: FloatArray) -> Steps:
    """The steps for a check of odometry. times (M,) [s], speeds (M,) [m/s]: commands, if any."""
    rows = np.array(found, dtype=np.float64).reshape(-1, len(ScanStep._fields))
    motion = rows[:, 2:5].copy()
    motion[[not step.fits for step in found]] = np.nan
    motion[[not step.tells_along for step in found], 0] = np.nan
    return Steps(rows[:, 0], rows[:, 1], motion, _commanded(rows[:, 1], times, speeds))


def _commanded(when: FloatArray, times: FloatArray, speeds: FloatArray) -> FloatArray:
    """(K,) the last command before each time, NaN if there is none."""
    if not len(times):
        return np.full(len(when), np.nan)
    before = np.searchsorted(times, when, side="right") - 1
    last = np.maximum(before, 0)
    holds = (before >= 0) & (when - times[last] <= COMMAND_HOLDS)
    return np.where(holds, speeds[last], np.nan)
