"""Evaluation of the localizer on a recording without ground truth: whether it finds the car and does not lose it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstlap import _core
from firstlap._core import Estimate
from firstlap.config.car_file import Car
from firstlap.evaluation.localization import percentiles
from firstlap.localization.localizer import Localizer
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.poses import wrap
from firstlap.recordings import Recording
from firstlap.tracks.track import FloatArray

ORIGIN = (0.0, 0.0, 0.0)
IN_MAP = "map"
"""The frame of recorded poses from a localizer."""
Pose = tuple[float, float, float]


@dataclass(frozen=True)
class Localized:
    """One entry per scan.

    start: initial pose x, y, yaw [m, rad]. estimated: (N, 3) poses in the map frame. recorded: (N, 3) recorded poses in
    that frame, or None. times: (N,) [s]. lost: (N,). fit: (N,) share of the scan that matches the map. took: (N,) CPU
    time of each step in microseconds.
    """

    start: Pose
    estimated: FloatArray
    recorded: FloatArray | None
    times: FloatArray
    lost: FloatArray
    fit: FloatArray
    took: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap localize RECORDING --json`. position [m], heading [degrees]: p50, p95 and max of the
        differences from the recorded poses, of scans that were not lost."""
        found = ~self.lost.astype(bool)
        difference = (
            np.full((len(self.estimated), 3), np.nan) if self.recorded is None else self.estimated - self.recorded
        )
        difference = difference[found & np.isfinite(difference).all(axis=1)]
        return {
            "scans": len(self.estimated),
            "seconds": round(float(self.times[-1] - self.times[0]), 3),
            "start": [round(value, 4) for value in self.start],
            "lost": round(float(1.0 - found.mean()), 5),
            "lost_at_end": bool(not found[-1]),
            "found_after": round(float(self.times[found.argmax()] - self.times[0]), 3) if found.any() else None,
            "fit": round(float(np.median(self.fit)), 3),
            "position": percentiles(np.hypot(*difference[:, :2].T)),
            "heading": percentiles(np.degrees(np.abs(wrap(difference[:, 2])))),
            "step_us": {**percentiles(self.took), "p99": round(float(np.percentile(self.took, 99)), 1)},
        }


def localize_recording(
    recording: Recording,
    known: OccupancyMap,
    car: Car,
    *,
    seed: int = 1,
    params: _core.LocalizerParams | None = None,
    on_progress: Callable[[int], object] | None = None,
) -> Localized:
    """Runs a localizer on the recording. It starts at the first recorded pose in the map, or at the map's start,
    whichever results in the better match of all scans. on_progress: called with the number of scans done, of all
    starts. Raises InputError for a map without walls."""
    attempts = []
    for number, start in enumerate(starts_of(recording, known)):
        localizer = Localizer(known, car, seed, params).start(start)
        steps = []
        for i in range(len(recording)):
            steps.append(_timed_step(localizer, recording, i))
            if on_progress:
                on_progress(number * len(recording) + i + 1)
        attempts.append((start, steps))
    start, best = max(attempts, key=lambda one: sum(estimate.fit for estimate, _ in one[1] if not estimate.lost))
    in_map = recording.poses is not None and start == _pose(recording.poses[0])
    return Localized(
        start=start,
        estimated=np.array([[e.x, e.y, e.yaw] for e, _ in best]),
        recorded=recording.poses if in_map else None,
        times=recording.stamps,
        lost=np.array([e.lost for e, _ in best], dtype=np.float64),
        fit=np.array([e.fit for e, _ in best]),
        took=np.array([spent for _, spent in best]),
    )


def starts_of(recording: Recording, known: OccupancyMap) -> list[Pose]:
    """Possible start poses in the map frame: the recorded one first, if any, then the map's start."""
    begun = known.start or ORIGIN
    recorded = recording.poses is not None and recording.frame == IN_MAP and np.isfinite(recording.poses[0]).all()
    return [_pose(recording.poses[0]), begun] if recorded and recording.poses is not None else [begun]


def _pose(row: FloatArray) -> Pose:
    x, y, yaw = row.tolist()
    return x, y, yaw


def _timed_step(localizer: Localizer, recording: Recording, i: int) -> tuple[Estimate, float]:
    scan, state, dt = recording.scan(i), recording.state(i), float(recording.dts[i])
    begin = time.thread_time_ns()
    estimate = localizer.step(scan, state, dt)
    return estimate, 1e-3 * (time.thread_time_ns() - begin)
