"""Logs a race while it is driven."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.recordings.about import About
from firstlap.recordings.write import Batch, LogWriter

FIRST_BATCH, MOST_SCANS = 40, 1000
BATCH_TIME = 0.05
"""[s] Duration of a batch. The GIL is needed only between batches, when the writer may hold it for some milliseconds;
the race of a slow driver must remain interruptible, and its log up to date."""


def race_about(running: _core.Race, setup: Setup, car: Car, what: str, seed: int) -> About:
    """The metadata of the log of a race that has not begun."""
    period = 1.0 / float(car.core.get("lidar", "rate"))  # type: ignore[arg-type]
    return About(setup, car, what=what, header=running.scan().header, scan_period=period, first_dt=period, seed=seed)


def drive_and_log(
    running: _core.Race,
    driver: _core.LoggedDriver,
    about: About,
    path: str | Path,
    on_progress: Callable[[_core.Race], object] | None,
) -> None:
    """Drives the race to its end and writes its log. Raises InputError if it cannot be written.

    driver: the driver of the race. on_progress: as for `firstlap.sim.race.race`.
    """
    scans, known, count = 0, 0, FIRST_BATCH
    with LogWriter(path, about) as writer:
        going = True
        while going:
            begin = time.perf_counter()
            going = running.advance(count)
            count = int(np.clip(count * BATCH_TIME / (time.perf_counter() - begin), 1, MOST_SCANS))
            columns = driver.take()
            if len(columns["dt"]):
                # A slow driver skips scans; dt gives their number.
                numbers = scans + np.cumsum(np.round(columns["dt"] / about.scan_period).astype(np.int64))
                truth = _core.truth(running, known)
                writer.put(_batch(columns, numbers, truth, known, about))
                scans = int(numbers[-1])
                known = scans
            if on_progress:
                on_progress(running)


def _batch(
    columns: dict[str, Any], numbers: npt.NDArray[np.int64], truth: dict[str, Any], known: int, about: About
) -> Batch:
    """numbers: (N,) of the scans, from 1. truth: at each scan from `known` + 1 on."""
    rows = numbers - known - 1
    return Batch(
        times=np.asarray(np.round(numbers * (about.scan_period or 0.0) * 1e9), dtype=np.int64),
        scan_time=about.scan_period or 0.0,
        ranges=np.split(columns["ranges"], np.cumsum(columns["sizes"])[:-1]),
        headers=columns["headers"],
        measured=columns["measured"],
        truth=(truth["pose"][rows], truth["motion"][rows]) if len(truth["pose"]) else None,
        columns=columns,
    )
