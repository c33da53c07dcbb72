"""Evaluates perception on many tracks, each separately."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.evaluation.perception.simulated import measure
from firstlap.evaluation.survey import InterruptedSurveyError, Run


def survey_perception(
    runs: Sequence[Run],
    setup: Setup,
    car: Car,
    *,
    laps: int = 1,
    done: Callable[[Run, dict[str, Any]], object] | None = None,
) -> list[dict[str, Any]]:
    """Races every run on all cores and evaluates its scans; returns a row per run, in order.

    done: called in this thread with the row of each finished run, also before an interruption.
    """
    stop = threading.Event()

    def on_progress(_race: _core.Race) -> None:
        if stop.is_set():
            raise InterruptedSurveyError

    def row(run: Run) -> dict[str, Any]:
        track = run.track.reversed() if run.reverse else run.track
        perception, outcome = measure(track, setup, car, laps=laps, seed=run.seed, on_progress=on_progress)
        return {
            "track": run.spec,
            "direction": "reverse" if run.reverse else "forward",
            "seed": run.seed,
            "outcome": outcome,
            **perception.to_dict(),
        }

    pool = ThreadPoolExecutor(max_workers=os.cpu_count())
    rows: dict[int, dict[str, Any]] = {}
    try:
        futures = {pool.submit(row, run): i for i, run in enumerate(runs)}
        for future in as_completed(futures):
            i = futures[future]
            rows[i] = future.result()
            if done:
                done(runs[i], rows[i])
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
    return [rows[i] for i in sorted(rows)]
