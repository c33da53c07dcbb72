"""Comparison of drivers with the same track, car, seeds and laps, on all cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
import statistics
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import DRIVERS, Preparation, driver_kind
from firstlap.config.setup_file import LOCAL, Setup, choose_setup
from firstlap.evaluation.compare.record import Record, Store, race_key, to_record
from firstlap.evaluation.published import LAPS_BY_GROUP, LAST
from firstlap.sim.race import latency_options, race
from firstlap.tracks.track import Track

ALSO_COMPARED: Mapping[str, tuple[str, ...]] = {LOCAL: ("brisk", LAST)}
"""By driver, setups compared by default beside its default one: our fastest for unknown tracks, and the paper's."""
GROUPS: Mapping[str, str] = {LOCAL: "local", "global": "global"}
"""The paper's group of a driver; the others are reactive."""


@dataclass
class Entry:
    """A driver with a setup, and its races."""

    setup: Setup
    preparation: Preparation = field(default_factory=Preparation)
    records: list[Record] = field(default_factory=list)

    @property
    def label(self) -> str:
        """The driver's name, or driver:setup if the setup is not its default."""
        default = driver_kind(self.setup.driver).default_setup
        return self.setup.driver if self.setup.name == default else f"{self.setup.driver}:{self.setup.name}"

    @property
    def needs_map(self) -> bool:
        """Whether the driver needs a map of the track."""
        return driver_kind(self.setup.driver).needs_map

    def summary(self) -> dict[str, Any]:
        """The row of the table; laps are the flying laps of finished races."""
        finished = [record for record in self.records if record.finished]
        laps = [lap for record in finished for lap in record.flying]
        times = [lap.time for lap in laps]
        compute = np.concatenate([record.compute_times for record in self.records] or [np.zeros(0, np.float32)])
        clearances = [lap.min_clearance for record in self.records for lap in record.laps]
        return {
            "driver": self.setup.driver,
            "setup": self.setup.name,
            "label": self.label,
            "tuned_for": self.setup.tuned_for or None,
            "needs_map": self.needs_map,
            "preparation": self.preparation.seconds,
            "runs": len(self.records),
            "finished": len(finished),
            "success_rate": len(finished) / len(self.records) if self.records else None,
            "best": min(times, default=None),
            "median": statistics.median(times) if times else None,
            "spread": statistics.pstdev(times) if times else None,
            "mean_speed": sum(lap.distance for lap in laps) / sum(times) if times else None,
            "distance": statistics.mean(lap.distance for lap in laps) if laps else None,
            "min_clearance": 0.0 if any(r.contact for r in self.records) else min(clearances, default=None),
            "compute_p50": float(np.percentile(compute, 50)) if len(compute) else None,
            "compute_p99": float(np.percentile(compute, 99)) if len(compute) else None,
            "skipped_scans": sum(record.skipped_scans for record in self.records),
        }


def default_entries() -> list[str]:
    """Every driver with its default setup, and what else a user would choose: `ALSO_COMPARED`."""
    return [word for name in DRIVERS for word in (name, *(f"{name}:{setup}" for setup in ALSO_COMPARED.get(name, ())))]


def parse_entries(text: str | None, car: Car) -> list[Entry]:
    """Parses "local:race,gap,gap:gap_arena"; None: `default_entries`. Raises InputError."""
    words = [word.strip() for word in text.split(",")] if text is not None else default_entries()
    entries: list[Entry] = []
    for word in words:
        name, colon, setup = word.partition(":")
        if not name or (colon and not setup):
            raise InputError(f"--drivers '{text}': expected comma-separated DRIVER or DRIVER:SETUP")
        driver_kind(name, "--drivers")
        entries.append(Entry(choose_setup(name, setup or None)))
        entries[-1].setup.params(car.core)
    labels = [entry.label for entry in entries]
    twice = next((label for label in labels if labels.count(label) > 1), None)
    if twice:
        raise InputError(f"--drivers '{text}': {twice} is named twice")
    return entries


class Comparison:
    """All entries on one track. Races in the store are not repeated."""

    def __init__(
        self,
        track: Track,
        entries: Sequence[Entry],
        car: Car,
        *,
        laps: int,
        seeds: int,
        latency: str,
        store: Store,
        options: Mapping[str, float] | None = None,
        jobs: int | None = None,
    ) -> None:
        """options: conditions of the table `OPTION_FIELDS`, for every race. Raises InputError."""
        latency_options(latency)
        self.track = track
        self.entries = list(entries)
        self.car = car
        self.laps = laps
        self.seeds = seeds
        self.latency = latency
        self.store = store
        self.options = dict(options or {})
        self.jobs = jobs or os.cpu_count() or 1
        self.from_store = 0

    @property
    def races(self) -> int:
        """Total number of races."""
        return len(self.entries) * self.seeds

    def drive(
        self,
        done: Callable[[Entry, Record], object] | None = None,
        preparing: Callable[[Entry, str, float], object] | None = None,
    ) -> None:
        """Runs the missing races; `done` is called in this thread after each, `preparing` while a driver prepares.

        If interrupted, finished races are kept, here and in the store.
        """
        missing = self._read_store(done)
        in_threads = [job for job in missing if not driver_kind(job.entry.setup.driver).in_python]
        in_processes = [job for job in missing if job not in in_threads]
        for entry in self.entries:
            if entry.needs_map:
                self._prepare(entry, preparing)
        for jobs, pool in ((in_threads, _Threads(self.jobs)), (in_processes, _Processes(self.jobs))):
            if jobs:
                pool.drive(self, jobs, done)
        for entry in self.entries:
            entry.records.sort(key=lambda record: record.seed)

    def key(self, setup: Setup, seed: int) -> str:
        """The key of a race in the store."""
        return race_key(self.track, setup, self.car, self.laps, seed, self.latency, self.options)

    def take(self, entry: Entry, record: Record, done: Callable[[Entry, Record], object] | None) -> None:
        """Stores the record of a race."""
        self.store.save(self.key(entry.setup, record.seed), record)
        entry.records.append(record)
        if done:
            done(entry, record)

    def _read_store(self, done: Callable[[Entry, Record], object] | None) -> list[_Job]:
        missing = []
        for entry in self.entries:
            for seed in range(1, self.seeds + 1):
                record = self.store.load(self.key(entry.setup, seed))
                if record is None:
                    missing.append(_Job(entry, seed))
                    continue
                self.from_store += 1
                entry.records.append(record)
                if done:
                    done(entry, record)
        return missing

    def _prepare(self, entry: Entry, preparing: Callable[[Entry, str, float], object] | None) -> None:
        def on_progress(what: str, share: float) -> None:
            if preparing:
                preparing(entry, what, share)

        kind = driver_kind(entry.setup.driver)
        entry.preparation = kind.prepare(self.track, entry.setup, self.car, 1, on_progress)

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap compare --json`."""
        rows = [entry.summary() for entry in self.entries]
        reference = reference_row(rows)
        for row in rows:
            both = reference is not None and row["median"] is not None
            row["relative"] = row["median"] / reference["median"] if both and reference else None
        return {
            "track": self.track.name,
            "track_length": round(self.track.length, 6),
            "car": self.car.name,
            "laps": self.laps,
            "seeds": self.seeds,
            "latency": self.latency,
            "options": self.options,
            "reference": reference["label"] if reference else None,
            "entries": rows,
            "order": group_gaps(best_of_groups(rows)),
            "published": group_gaps(published_of_groups(rows)),
        }


def reference_row(rows: Iterable[dict[str, Any]]) -> dict[str, Any] | None:
    """The reference row for lap times: global, or the fastest of those with the highest success rate."""
    driven = [row for row in rows if row["median"] is not None]
    known = [row for row in driven if row["driver"] == "global"]
    candidates = known or driven
    return min(candidates, key=lambda row: (-(row["success_rate"] or 0.0), row["median"]), default=None)


def best_of_groups(rows: Iterable[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The fastest row of each of the paper's groups that finished every race."""
    best: dict[str, dict[str, Any]] = {}
    for row in rows:
        group = GROUPS.get(row["driver"], "reactive")
        if _reliable(row) and (group not in best or row["median"] < best[group]["median"]):
            best[group] = row
    return best


def published_of_groups(rows: Iterable[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """As `best_of_groups`, with the paper's setting for the group local, if it was raced and finished every race."""
    rows = list(rows)
    best = best_of_groups(row for row in rows if row["driver"] != LOCAL)
    for row in rows:
        if (row["driver"], row["setup"]) == (LOCAL, LAST) and _reliable(row):
            best["local"] = row
    return best


def _reliable(row: Mapping[str, Any]) -> bool:
    return row["median"] is not None and row["success_rate"] == 1.0


def group_gaps(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Our median laps in the paper's groups, and how much slower one is than the next, ours and the paper's."""
    gaps = {}
    for slower, faster in (("reactive", "local"), ("local", "global")):
        ours = rows[slower]["median"] / rows[faster]["median"] - 1.0 if slower in rows and faster in rows else None
        paper = LAPS_BY_GROUP[slower] / LAPS_BY_GROUP[faster] - 1.0
        gaps[f"{slower}_to_{faster}"] = {"ours": ours, "paper": paper}
    laps = {
        name: {"median": row["median"], "label": row["label"], "tuned_for": row["tuned_for"]}
        for name, row in rows.items()
    }
    return {"laps": laps, "gaps": gaps}


@dataclass(frozen=True)
class _Job:
    entry: Entry
    seed: int

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)


class InterruptedComparisonError(Exception):
    """The races were interrupted."""


class _Threads:
    """Runs core drivers in threads: their races release the GIL."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._stop = threading.Event()

    def drive(self, comparison: Comparison, jobs: Sequence[_Job], done: Callable[..., object] | None) -> None:
        pool = ThreadPoolExecutor(max_workers=self.jobs)
        _collect(pool, {pool.submit(self._race, comparison, job): job for job in jobs}, comparison, done, self._stop)

    def _race(self, comparison: Comparison, job: _Job) -> Record:
        return to_record(
            race(
                comparison.track,
                job.entry.setup,
                comparison.car,
                laps=comparison.laps,
                seed=job.seed,
                latency=comparison.latency,
                preparation=job.entry.preparation,
                options=comparison.options,
                on_progress=self._check_stop,
            )
        )

    def _check_stop(self, _running: object) -> None:
        if self._stop.is_set():
            raise InterruptedComparisonError


class _Processes:
    """Runs Python drivers in processes, each with its own interpreter."""

    begin: Callable[[], object] | None = None
    """Called in each process before its first race, to register drivers that are not our own."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def drive(self, comparison: Comparison, jobs: Sequence[_Job], done: Callable[..., object] | None) -> None:
        context = multiprocessing.get_context("spawn")
        stop = context.Event()
        track = replace(comparison.track)  # without its cached properties
        pool = ProcessPoolExecutor(min(self.jobs, len(jobs)), context, _begin_process, (stop, self.begin))
        car = (comparison.car.name, comparison.car.core.values())
        futures = {}
        for job in jobs:
            given = job.entry.setup, job.seed, job.entry.preparation
            arguments = (track, car, comparison.laps, comparison.latency, comparison.options, *given)
            futures[pool.submit(_race_in_process, *arguments)] = job
        _collect(pool, futures, comparison, done, stop)


def _collect(
    pool: Executor,
    futures: dict[Future[Record], _Job],
    comparison: Comparison,
    done: Callable[..., object] | None,
    stop: Any,
) -> None:
    try:
        for future in as_completed(futures):
            comparison.take(futures[future].entry, future.result(), done)
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


_stop_process: Any = None


def _begin_process(stop: Any, begin: Callable[[], object] | None) -> None:
    """Ignores Ctrl-C; the parent handles it and sets `stop`."""
    global _stop_process
    if begin:
        begin()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stop_process = stop


def _race_in_process(
    track: Track,
    car: tuple[str, dict[str, dict[str, float]]],
    laps: int,
    latency: str,
    options: dict[str, float],
    setup: Setup,
    seed: int,
    preparation: Preparation,
) -> Record:
    def on_progress(_running: object) -> None:
        if _stop_process.is_set():
            raise InterruptedComparisonError

    name, values = car
    core = _core.Car()
    for section, fields in values.items():
        for field_name, value in fields.items():
            core.set(section, field_name, value)
    return to_record(
        race(
            track,
            setup,
            Car(name, core),
            laps=laps,
            seed=seed,
            latency=latency,
            preparation=preparation,
            options=options,
            on_progress=on_progress,
        )
    )


def stamp() -> str:
    """Date and time, UTC, for reports."""
    return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
