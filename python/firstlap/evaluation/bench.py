"""Benchmarks: timings measured in C++, with a reference from the same run."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.sim.lidar import core_track
from firstlap.tracks.track import Track


def bench(track: Track, setup: Setup, car: Car, scans: int = 4000) -> dict[str, Any]:
    """step_us, scan_us and reference_us (p50, p99, max) in microseconds, and realtime_factor.

    The reference turns every beam of a scan into a point by cos and sin, in the same process and on the same scans.
    Raises InputError.
    """
    try:
        found = _core.bench(core_track(track), car.core, setup.params(car.core), scans)
    except ValueError as error:
        raise InputError(f"{track.name}: {error}") from None
    return {
        "track": track.name,
        "setup": setup.name,
        "car": car.name,
        "scans": len(found["step_us"]),
        "step_us": _spread(found["step_us"]),
        "scan_us": _spread(found["scan_us"]),
        "reference_us": _spread(found["reference_us"]),
        "realtime_factor": round(found["realtime_factor"], 1),
    }


def _spread(times: npt.NDArray[np.float64]) -> dict[str, float]:
    p50, p99 = np.percentile(times, [50, 99])
    return {"p50": round(float(p50), 2), "p99": round(float(p99), 2), "max": round(float(times.max()), 2)}
