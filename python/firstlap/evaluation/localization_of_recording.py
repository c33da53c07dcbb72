"""What a localizer says of a recording: where nobody knows the truth, whether it finds the car and keeps it."""

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
"""The frame of recorded poses that a localizer gave."""
Pose = tuple[float, float, float]


@dataclass(frozen=True)
class Localized:
    """One entry per scan.

    start: x, y, yaw [m, rad] that the filter was given. said: (N, 3) poses in the map's frame. recorded: (N, 3) those
    that the recording has in that frame, or None. times: (N,) [s]. lost: (N,). fit: (N,) share of the scan on the map.
    took: (N,) microseconds of processor time of each step.
    """

    start: Pose
    said: FloatArray
    recorded: FloatArray | None
    times: FloatArray
    lost: FloatArray
    fit: FloatArray
    took: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """As `firstlap localize RECORDING --json` prints it. position [m], heading [degrees]: p50, p95 and max of the
        differences from the recorded poses, where it is not lost."""
        found = ~self.lost.astype(bool)
        apart = np.full((len(self.said), 3), np.nan) if self.recorded is None else self.said - self.recorded
        apart = apart[found & np.isfinite(apart).all(axis=1)]
        return {
            "scans": len(self.said),
            "seconds": round(float(self.times[-1] - self.times[0]), 3),
            "start": [round(value, 4) for value in self.start],
            "lost": round(float(1.0 - found.mean()), 5),
            "lost_at_end": bool(not found[-1]),
            "found_after": round(float(self.times[found.argmax()] - self.times[0]), 3) if found.any() else None,
            "fit": round(float(np.median(self.fit)), 3),
            "position": percentiles(np.hypot(*apart[:, :2].T)),
            "heading": percentiles(np.degrees(np.abs(wrap(apart[:, 2])))),
            "step_us": {**percentiles(self.took), "p99": round(float(np.percentile(self.took, 99)), 1)},
        }


def localize_recording(
    recording: Recording,
    known: OccupancyMap,
    car: Car,
    *,
    seed: int = 1,
    params: _core.LocalizerParams | None = None,
    look: Callable[[int], object] | None = None,
) -> Localized:
    """Lets a localizer follow the recorded car. It begins where the recording has the car in a map, or where the map
    was begun: of the two that keeps more of all scans on the map. look: is told how many scans of all starts are done.
    Raises InputError for a map without walls."""
    followed = []
    for number, start in enumerate(starts_of(recording, known)):
        localizer = Localizer(known, car, seed, params).start(start)
        steps = []
        for i in range(len(recording)):
            steps.append(_timed_step(localizer, recording, i))
            if look:
                look(number * len(recording) + i + 1)
        followed.append((start, steps))
    start, best = max(followed, key=lambda one: sum(estimate.fit for estimate, _ in one[1] if not estimate.lost))
    in_map = recording.poses is not None and start == _pose(recording.poses[0])
    return Localized(
        start=start,
        said=np.array([[e.x, e.y, e.yaw] for e, _ in best]),
        recorded=recording.poses if in_map else None,
        times=recording.stamps,
        lost=np.array([e.lost for e, _ in best], dtype=np.float64),
        fit=np.array([e.fit for e, _ in best]),
        took=np.array([spent for _, spent in best]),
    )


def starts_of(recording: Recording, known: OccupancyMap) -> list[Pose]:
    """Where the car may be at the first scan, in the map's frame: what the recording says comes first."""
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
