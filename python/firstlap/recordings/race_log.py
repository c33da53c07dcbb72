"""A race that is logged while it is driven."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from firstlap import _core
from firstlap.car_file import Car
from firstlap.recordings.about import About
from firstlap.recordings.write import Batch, LogWriter
from firstlap.setup_file import Setup

SCANS_PER_BATCH = 200
HEADER = ("angle_min", "angle_increment", "time_increment", "range_min", "range_max")


def drive_and_log(
    running: _core.Race,
    racer: _core.Racer | None,
    about: About,
    path: str | Path,
    look: Callable[[_core.Race], object] | None,
) -> None:
    """Drives the race to its end and writes its log. Raises InputError where that cannot be written.

    racer: the race's driver where it is one, for its intermediate results. look: as of `firstlap.race.race`.
    """
    log = _core.RaceLog(running, racer)
    with LogWriter(path, about) as writer:
        going = True
        while going:
            columns = log.advance(SCANS_PER_BATCH)
            going = columns["going"]
            if len(columns["time"]):
                writer.put(_batch(columns, running.scan()))
            if look:
                look(running)


def race_about(running: _core.Race, setup: Setup, car: Car, what: str, seed: int) -> About:
    """What the log of a race that has not begun says of itself."""
    period = 1.0 / float(car.core.get("lidar", "rate"))  # type: ignore[arg-type]
    header = exact_header(running.scan())
    return About(setup, car, what=what, header=header, scan_period=period, first_dt=period, seed=seed)


def exact_header(scan: dict[str, Any]) -> tuple[float, ...]:
    """The numbers of a scan's header."""
    return tuple(float(scan[name]) for name in HEADER)


def _batch(columns: dict[str, Any], scan: dict[str, Any]) -> Batch:
    count = len(columns["time"])
    return Batch(
        times=np.asarray(np.round(columns["time"] * 1e9), dtype=np.int64),
        ranges=columns["ranges"],
        headers=np.tile(exact_header(scan), (count, 1)),
        measured=columns["measured"],
        truth=(columns["pose"], columns["truth"][:, :2]),
        columns=columns,
    )
