"""Measures races, disturbances, recordings and perception with one rule of the method turned off at a time."""

from __future__ import annotations

import json
import math
import os
import statistics
import threading
from collections.abc import Callable, Iterator, Sequence, Set
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.evaluation.ablation.rules import Rule
from firstlap.evaluation.perception.simulated import measure as measure_perception
from firstlap.evaluation.replay.replay import replay
from firstlap.evaluation.robustness.cases import BY_NAME, PIPE_LENGTH, Case, Robustness
from firstlap.recordings.recording import Recording
from firstlap.sim.race import race
from firstlap.tracks.cut_walls import with_pipes
from firstlap.tracks.track import Track

REFERENCE = "all rules"
START_YAWS = (-1.0, -0.6, 0.6, 1.0)
"""[rad] Heading errors of the start pose."""
JOINTS = (0.5, 0.8)
"""[m] Widths of the joints between pipes; values of the sweep pipe_joints."""
SIGHTS = (1.5, 3.0)
"""Visibility of the sudden obstacle, in stopping distances; values of the sweep obstacle."""


@dataclass(frozen=True)
class Plan:
    """The measurements of every rule.

    tracks: raced in both directions. disturbed: those that are also raced with joints, sudden obstacles and turned
    starts. perceived: those on which perception is evaluated. places: number of obstacles per lap.
    """

    setups: Sequence[Setup]
    tracks: dict[str, Track]
    disturbed: Sequence[str]
    perceived: Sequence[str]
    recordings: Sequence[Recording]
    laps: int = 1
    seeds: int = 1
    places: int = 2


@dataclass(frozen=True)
class Job:
    """One measurement: `run` returns its result as JSON data."""

    rule: str
    kind: str
    case: str
    run: Callable[[], dict[str, Any]]

    @property
    def key(self) -> str:
        """Key of the result in the state file."""
        return f"{self.rule} | {self.kind} | {self.case}"


class InterruptedAblationError(Exception):
    """The measurements were interrupted."""


@dataclass
class Ablation:
    """Runs the plan with each rule turned off in turn, and with all rules on, on all cores.

    state: file from which an interrupted run is resumed. reference: name of the setups as they are.
    """

    plan: Plan
    car: Car
    rules: Sequence[Rule]
    state: Path | None = None
    reference: str = REFERENCE
    found: dict[str, dict[str, Any]] = field(default_factory=dict)
    _stop: threading.Event = field(default_factory=threading.Event)

    def jobs(self) -> Iterator[Job]:
        """All measurements; those with all rules on come first. Rules that a setup turns off anyway are skipped for
        that setup."""
        for rule in (None, *self.rules):
            name = rule.name if rule else self.reference
            for number, setup in enumerate(self.plan.setups):
                changed = setup.with_assignments(rule.assignments) if rule else setup
                if rule and changed.params(self.car.core).values() == setup.params(self.car.core).values():
                    continue
                yield from self._races(name, changed)
                yield from self._disturbed(name, changed)
                if number == 0:
                    yield from self._perceived(name, changed)

    def run(self, done: Callable[[Job], object] | None = None) -> None:
        """Runs the measurements that are not in the state file; `done` is called in this thread after each. If
        interrupted, finished measurements are kept. Raises InputError for a damaged state file.
        """
        jobs = list(self.jobs())
        self._read_state({job.key for job in jobs})
        pool = ThreadPoolExecutor(max_workers=os.cpu_count())
        try:
            futures = {pool.submit(job.run): job for job in jobs if job.key not in self.found}
            for job in jobs:
                if done and job.key in self.found:
                    done(job)
            for future in as_completed(futures):
                job = futures[future]
                self._keep(job.key, future.result())
                if done:
                    done(job)
        finally:
            self._stop.set()
            pool.shutdown(wait=True, cancel_futures=True)

    def _read_state(self, planned: Set[str]) -> None:
        """Takes over the results of planned measurements; the file may hold those of other plans, too."""
        if self.state is None or not self.state.exists():
            return
        try:
            lines = self.state.read_text().splitlines()
            results = dict([json.loads(line) for line in lines])
            self.found.update({key: result for key, result in results.items() if key in planned})
        except (ValueError, TypeError) as error:
            raise InputError(
                f"{self.state}: is not a state file of an ablation ({error}); delete it or use another file"
            ) from None
        except OSError as error:
            raise InputError(f"{self.state}: {error.strerror or error}") from None

    def _keep(self, key: str, result: dict[str, Any]) -> None:
        self.found[key] = result
        if self.state is None:
            return
        try:
            with self.state.open("a") as file:
                file.write(json.dumps([key, result]) + "\n")
        except OSError as error:
            raise InputError(f"{self.state}: {error.strerror or error}") from None

    def _races(self, rule: str, setup: Setup) -> Iterator[Job]:
        for spec, track in self.plan.tracks.items():
            for reverse in (False, True):
                for seed in range(1, self.plan.seeds + 1):
                    case = f"{setup.name} {spec} {'reverse' if reverse else 'forward'} {seed}"
                    yield Job(rule, "race", case, partial(self._race, setup, track, reverse=reverse, seed=seed))

    def _disturbed(self, rule: str, setup: Setup) -> Iterator[Job]:
        for spec in self.plan.disturbed:
            track = self.plan.tracks[spec]
            for yaw in START_YAWS:
                turned = partial(self._race, setup, track, options={"start_yaw": yaw})
                yield Job(rule, "turned", f"{setup.name} {spec} {yaw:g}", turned)
            for joint in JOINTS:
                cut = with_pipes(track, PIPE_LENGTH, [joint])
                yield Job(rule, "joints", f"{setup.name} {spec} {joint:g}", partial(self._race, setup, cut))
            yield Job(rule, "boxes", f"{setup.name} {spec}", partial(self._boxes, setup, spec, track))

    def _perceived(self, rule: str, setup: Setup) -> Iterator[Job]:
        for spec in self.plan.perceived:
            yield Job(rule, "perception", spec, partial(self._perception, setup, self.plan.tracks[spec]))
        for recording in self.plan.recordings:
            yield Job(rule, "recording", recording.name, partial(self._replayed, setup, recording))

    def _race(
        self, setup: Setup, track: Track, reverse: bool = False, seed: int = 1, options: dict[str, float] | None = None
    ) -> dict[str, Any]:
        laps = self.plan.laps
        result = race(
            track, setup, self.car, laps=laps, seed=seed, reverse=reverse, options=options, on_progress=self._check_stop
        )
        lap = statistics.median(lap.time for lap in result.laps) if result.finished else None
        return {"passed": int(result.finished), "cases": 1, "lap": lap}

    def _boxes(self, setup: Setup, spec: str, track: Track) -> dict[str, Any]:
        races = Robustness(setup, self.car, self.plan.laps)
        sweep = BY_NAME["obstacle"]
        judged = []
        for case in races.cases([sweep], {spec: track}, 1, False, self.plan.places):
            self._check_stop()
            if case.value in SIGHTS:
                judged.append(self._box(races, case))
        passed = [drive for drive in judged if drive is not None]
        return {"passed": sum(passed), "cases": len(passed)}

    @staticmethod
    def _box(races: Robustness, case: Case) -> bool | None:
        """Whether there was no contact; None if no driver could have avoided it."""
        drive = races.race(case)
        return None if drive.verdict in ("impossible", "before") else drive.contact_free

    def _perception(self, setup: Setup, track: Track) -> dict[str, Any]:
        perception, _ = measure_perception(track, setup, self.car, on_progress=self._check_stop)
        return perception.to_dict()

    def _replayed(self, setup: Setup, recording: Recording) -> dict[str, Any]:
        return replay(recording, setup, self.car, on_progress=self._check_stop).driven.to_dict()

    def _check_stop(self, _running: object = None) -> None:
        if self._stop.is_set():
            raise InterruptedAblationError

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap ablation --json`: one row per rule, with all rules on first."""
        rows = [self._row(rule) for rule in (Rule(self.reference, "", 0), *self.rules)]
        return {
            "setups": [setup.name for setup in self.plan.setups],
            "car": self.car.name,
            "tracks": list(self.plan.tracks),
            "disturbed": list(self.plan.disturbed),
            "perceived": list(self.plan.perceived),
            "recordings": [recording.name for recording in self.plan.recordings],
            "laps": self.plan.laps,
            "seeds": self.plan.seeds,
            "places": self.plan.places,
            "rules": rows,
        }

    def _row(self, rule: Rule) -> dict[str, Any]:
        row: dict[str, Any] = {"rule": rule.name, "off": rule.off, "lines": rule.lines}
        for kind in ("race", "turned", "joints", "boxes"):
            own = self._of(rule.name, kind).values()
            row[kind] = {count: sum(found[count] for found in own) for count in ("passed", "cases")}
        row["lap_ratio"], row["worst_lap_ratio"] = self._lap_ratios(rule.name)
        row["perception"] = _mean_of(self._of(rule.name, "perception"), _perception_figures)
        row["recordings"] = _mean_of(self._of(rule.name, "recording"), _recording_figures)
        return row

    def _of(self, rule: str, kind: str) -> dict[str, dict[str, Any]]:
        """Results by case; for setups that turn the rule off anyway, those with all rules on."""
        found: dict[str, dict[str, Any]] = {}
        for name in (self.reference, rule):
            prefix = f"{name} | {kind} | "
            found |= {key.removeprefix(prefix): result for key, result in self.found.items() if key.startswith(prefix)}
        return found

    def _lap_ratios(self, rule: str) -> tuple[float | None, float | None]:
        """Mean and maximum ratio of the lap time to that with all rules on, over races that finished in both cases."""
        reference = self._of(self.reference, "race")
        ratios = [
            found["lap"] / reference[case]["lap"]
            for case, found in self._of(rule, "race").items()
            if found["lap"] and case in reference and reference[case]["lap"]
        ]
        return (statistics.fmean(ratios), max(ratios)) if ratios else (None, None)


def _perception_figures(found: dict[str, Any]) -> dict[str, float | None]:
    return {
        "error_1m": found["error"]["1"]["median"],
        "error_2m_p95": found["error"]["2"]["p95"],
        "failures": found["bad"],
        "precision": found["precision"],
        "recall": found["recall"],
        "jump_p95": found["jump"]["p95"],
    }


def _recording_figures(found: dict[str, Any]) -> dict[str, float | None]:
    return {
        "reaches_2m": found["available"]["2"],
        "jump_p95": found["jump"]["p95"],
        "big_jumps": found["jump"]["big"],
        "side_changes": found["changes_of_side"]["share"],
    }


def _mean_of(
    found: dict[str, dict[str, Any]], figures: Callable[[dict[str, Any]], dict[str, float | None]]
) -> dict[str, float | None]:
    """The mean of each figure over the cases; None if a case lacks it."""
    rows = [figures(one) for one in found.values()]
    means: dict[str, float | None] = {}
    for name in rows[0] if rows else ():
        values = [math.nan if row[name] is None else float(row[name] or 0.0) for row in rows]
        mean = statistics.fmean(values)
        means[name] = None if math.isnan(mean) else round(mean, 5)
    return means
