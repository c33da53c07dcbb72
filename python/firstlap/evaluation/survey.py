"""Surveys: many races with one setup."""

from __future__ import annotations

import os
import statistics
import threading
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from typing import Any

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.config.setup_file import Setup
from firstlap.sim.race import RaceResult, race
from firstlap.sim.race_process import RacePool, bare, packed, race_in_process, restored
from firstlap.tracks.track import Track


@dataclass(frozen=True)
class Run:
    """One race to drive."""

    spec: str
    track: Track
    reverse: bool
    seed: int


@dataclass
class TrackSummary:
    """Summary of the races on one track."""

    spec: str
    length: float
    results: list[RaceResult] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """runs, finished, success_rate, best and median lap [s], min_clearance [m], failures."""
        ordered = sorted(self.results, key=lambda result: (result.direction, result.seed))
        finished = [result for result in ordered if result.finished]
        flying = [lap.time for result in finished for lap in result.laps if not lap.standing]
        laps = flying or [lap.time for result in finished for lap in result.laps]
        clearances = [lap.min_clearance for result in ordered for lap in result.laps]
        return {
            "track": self.spec,
            "track_length": round(self.length, 6),
            "runs": len(ordered),
            "finished": len(finished),
            "success_rate": len(finished) / len(ordered) if ordered else None,
            "best": min(laps, default=None),
            "median": statistics.median(laps) if laps else None,
            "min_clearance": 0.0 if any(r.contact for r in ordered) else min(clearances, default=None),
            "failures": [
                {
                    "direction": result.direction,
                    "seed": result.seed,
                    "outcome": result.outcome,
                    "laps": len(result.laps),
                    "time": result.time,
                    "s": float(result.path["s"][-1]) if len(result.path["s"]) else 0.0,
                    "ending": asdict(result.ending) if result.ending else None,
                }
                for result in ordered
                if not result.finished
            ],
        }


class InterruptedSurveyError(Exception):
    """The races were interrupted."""


class Survey:
    """Every track, direction and seed with one setup, on all cores. The core races without the GIL."""

    def __init__(self, setup: Setup, car: Car, laps: int, options: Mapping[str, float] | None = None) -> None:
        """options: conditions of every race, of the table `OPTION_FIELDS`."""
        self.setup = setup
        self.car = car
        self.laps = laps
        self.options = dict(options or {})
        self.summaries: dict[str, TrackSummary] = {}
        self._stop = threading.Event()
        self._preparing = threading.Lock()
        self._preparations: dict[tuple[str, bool], Preparation] = {}

    def drive(self, runs: Iterable[Run], done: Callable[[Run, RaceResult], object] | None = None) -> None:
        """Runs all races; `done` is called in this thread after each. If interrupted, finished races are kept."""
        jobs = os.cpu_count() or 1
        if driver_kind(self.setup.driver).in_python:
            processes = RacePool(jobs)
            self._drive(processes, runs, lambda run: self._sent(processes, run), done, processes.stop)
            return
        threads = ThreadPoolExecutor(max_workers=jobs)
        self._drive(threads, runs, lambda run: threads.submit(self._race, run), done, self._stop)

    def _drive(
        self,
        pool: Executor,
        runs: Iterable[Run],
        submit: Callable[[Run], Future[Any]],
        done: Callable[[Run, RaceResult], object] | None,
        stop: Any,
    ) -> None:
        try:
            futures = {}
            for run in runs:
                self.summaries.setdefault(run.spec, TrackSummary(run.spec, run.track.length))
                futures[submit(run)] = run
            for future in as_completed(futures):
                run, found = futures[future], future.result()
                if not isinstance(found, RaceResult):
                    track = run.track.reversed() if run.reverse else run.track
                    found = restored(found, track, self.setup, self.car)
                self.summaries[run.spec].results.append(found)
                if done:
                    done(run, found)
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)

    def _sent(self, pool: RacePool, run: Run) -> Future[Any]:
        """Runs the race in another process."""
        options = {
            "laps": self.laps,
            "seed": run.seed,
            "reverse": run.reverse,
            "preparation": self._prepared(run),
            "options": self.options,
        }
        return pool.submit(race_in_process, bare(run.track), self.setup, packed(self.car), options)

    def _race(self, run: Run) -> RaceResult:
        return race(
            run.track,
            self.setup,
            self.car,
            laps=self.laps,
            seed=run.seed,
            reverse=run.reverse,
            preparation=self._prepared(run),
            options=self.options,
            on_progress=self._check_stop,
        )

    def _prepared(self, run: Run) -> Preparation:
        """The driver's preparation for the track, once for all seeds."""
        with self._preparing:
            key = run.spec, run.reverse
            if key not in self._preparations:
                track = run.track.reversed() if run.reverse else run.track
                kind = driver_kind(self.setup.driver)
                self._preparations[key] = kind.prepare(track, self.setup, self.car, 1, None)
            return self._preparations[key]

    def _check_stop(self, _running: _core.Race) -> None:
        if self._stop.is_set():
            raise InterruptedSurveyError

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap survey --json`."""
        tracks = [summary.to_dict() for summary in self.summaries.values()]
        runs = sum(track["runs"] for track in tracks)
        finished = sum(track["finished"] for track in tracks)
        return {
            "driver": self.setup.driver,
            "setup": self.setup.name,
            "set": {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()},
            "car": self.car.name,
            "options": self.options,
            "laps": self.laps,
            "runs": runs,
            "finished": finished,
            "success_rate": finished / runs if runs else None,
            "tracks": tracks,
        }
