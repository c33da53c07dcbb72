"""Logs a replay: the recorded scans with the planner's results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.recordings.about import About
from firstlap.recordings.recording import Recording
from firstlap.recordings.step_log import Columns


class Log:
    """Receives the columns of a replay, batch by batch."""

    def __init__(self, recording: Recording, setup: Setup, car: Car, path: str | Path) -> None:
        from firstlap.recordings.write import LogWriter

        same = bool(np.all(recording.headers == recording.headers[0]))
        about = About(
            setup,
            car,
            what=f"replay of {recording.name}",
            header=tuple(recording.headers[0].tolist()) if same else None,
            scan_period=recording.about.scan_period if recording.about else None,
            first_dt=float(recording.dts[0]),
        )
        self._recording = recording
        self.writer = LogWriter(path, about)
        self._scan_time = about.scan_period or float(np.median(recording.dts))
        self._times = round(recording.start * 1e9) + np.asarray(np.round(recording.stamps * 1e9), dtype=np.int64)

    def put(self, part: slice, columns: Columns) -> None:
        """Writes the columns of a batch of scans. Raises InputError if they cannot be written."""
        from firstlap.recordings.write import Batch

        recording = self._recording
        poses = recording.poses[part] if recording.poses is not None and recording.frame == "map" else None
        self.writer.put(
            Batch(
                times=self._times[part],
                scan_time=self._scan_time,
                ranges=recording.ranges[part],
                headers=recording.headers[part],
                measured=recording.states[part],
                truth=None if poses is None else (poses, recording.states[part, :2]),
                columns=columns,
            )
        )


@contextmanager
def log_of(recording: Recording, setup: Setup, car: Car, path: str | Path) -> Iterator[Log]:
    """A log as a context manager. Raises InputError if it cannot be written."""
    log = Log(recording, setup, car, path)
    with log.writer:
        yield log
