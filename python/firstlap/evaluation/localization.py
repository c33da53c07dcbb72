"""Accuracy of the localizer on a racing car with known ground truth."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstlap import _core
from firstlap._core import Estimate
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.drivers.racer import Racer
from firstlap.localization.localizer import Localizer
from firstlap.mapping.alignment import align
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.mapping.poses import compose, wrap
from firstlap.sim.race import start_race
from firstlap.tracks.track import FloatArray, Track

NEAR, TURNED = 0.1, np.radians(3.0)
SCANS_PER_CALLBACK = 40


@dataclass(frozen=True)
class Disturbance:
    """An error of the start pose of `start` [m] and `heading` [rad] in a random direction; and every `every` [s] the
    filter's pose is displaced by `kidnap` [m], as if the car had been moved."""

    start: float = 0.0
    heading: float = 0.0
    kidnap: float = 0.0
    every: float = 3.0


@dataclass(frozen=True)
class Followed:
    """A race and the localizer's estimates: one entry per scan.

    truth, estimated: (N, 3) poses in the track's frame. lost: (N,). took: (N,) CPU time of each step in microseconds.
    kidnapped: scans before which the filter was displaced.
    """

    outcome: str
    laps: int
    period: float
    truth: FloatArray
    estimated: FloatArray
    speed: FloatArray
    lost: FloatArray
    fit: FloatArray
    took: FloatArray
    kidnapped: list[int]

    @property
    def distance(self) -> FloatArray:
        """(N,) error of the position [m]."""
        return np.hypot(*(self.estimated - self.truth)[:, :2].T)

    @property
    def turn(self) -> FloatArray:
        """(N,) absolute error of the heading [rad]."""
        return np.abs(wrap(self.estimated[:, 2] - self.truth[:, 2]))

    def recoveries(self) -> list[float | None]:
        """Seconds from the start and from each kidnapping until the pose is correct for at least one second."""
        good = (self.distance < NEAR) & (self.turn < TURNED) & ~self.lost.astype(bool)
        hold = round(1.0 / self.period)
        times: list[float | None] = []
        for begin, end in zip([0, *self.kidnapped], [*self.kidnapped, len(good)], strict=True):
            runs = [i for i in range(begin, end) if good[i : min(i + hold, end)].all()]
            times.append((runs[0] - begin) * self.period if runs else None)
        return times

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap localize --json`: p50, p95, max of scans that were not lost, m and degrees."""
        found = ~self.lost.astype(bool)
        recoveries = self.recoveries()
        return {
            "outcome": self.outcome,
            "laps": self.laps,
            "scans": len(self.lost),
            "mean_speed": round(float(self.speed.mean()), 3),
            "top_speed": round(float(self.speed.max()), 3),
            "lost": round(float(1.0 - found.mean()), 5) if len(found) else 1.0,
            "lost_at_end": bool(len(found) == 0 or not found[-1]),
            "position": percentiles(self.distance[found]),
            "heading": percentiles(np.degrees(self.turn[found])),
            "fit": round(float(np.median(self.fit)), 3),
            "step_us": {**percentiles(self.took), "p99": round(float(np.percentile(self.took, 99)), 1)},
            "found_after": recoveries[0],
            "kidnapped": len(self.kidnapped),
            "recovered": sum(t is not None for t in recoveries[1:]),
            "recovered_after": max((t for t in recoveries[1:] if t is not None), default=None),
        }


def follow(
    track: Track,
    known: OccupancyMap,
    setup: Setup,
    car: Car,
    *,
    laps: int = 2,
    seed: int = 1,
    params: _core.LocalizerParams | None = None,
    disturbance: Disturbance | None = None,
    scans: int | None = None,
    on_progress: Callable[[_core.Race], object] | None = None,
) -> Followed:
    """Races the map-less driver and runs a localizer on the same scans and noisy odometry.

    For the evaluation only, the map's frame is aligned with the track's by the best fit of its walls; the localizer
    gets the map's own start. scans: maximum number of scans. Raises InputError.
    """
    wrong = disturbance or Disturbance()
    race = start_race(track, Racer(setup, car), car, laps=laps, seed=seed)
    frame = align(known, track, race.pose)
    rng = np.random.default_rng(seed)
    localizer = Localizer(known, car, seed, params)
    localizer.start(_wrong_start(known, wrong, rng))
    period = 1.0 / float(car.core.get("lidar", "rate"))  # type: ignore[arg-type]
    truth, speed, took, kidnapped = [], [], [], []
    estimated: list[Estimate] = []
    next_kidnap = wrong.every
    while race.advance(1) and (scans is None or len(estimated) < scans):
        if wrong.kidnap and race.time > next_kidnap:
            direction = rng.uniform(-np.pi, np.pi)
            localizer.core.displace(wrong.kidnap * np.cos(direction), wrong.kidnap * np.sin(direction), 0.0)
            kidnapped.append(len(estimated))
            next_kidnap += wrong.every
        estimate, spent = _timed_step(localizer, race, period)
        truth.append(race.pose)
        speed.append(race.state().speed)
        estimated.append(estimate)
        took.append(spent)
        if on_progress and len(estimated) % SCANS_PER_CALLBACK == 0:
            on_progress(race)
    poses = compose(frame, np.array([[e.x, e.y, e.yaw] for e in estimated]).reshape(-1, 3))
    return Followed(
        outcome=race.result()["outcome"],
        laps=race.laps_done(),
        period=period,
        truth=np.array(truth).reshape(-1, 3),
        estimated=poses,
        speed=np.array(speed),
        lost=np.array([e.lost for e in estimated], dtype=np.float64),
        fit=np.array([e.fit for e in estimated]),
        took=np.array(took),
        kidnapped=kidnapped,
    )


def _wrong_start(known: OccupancyMap, wrong: Disturbance, rng: np.random.Generator) -> tuple[float, float, float]:
    x, y, yaw = known.start or (0.0, 0.0, 0.0)
    direction = rng.uniform(-np.pi, np.pi)
    turn = wrong.heading * rng.choice([-1.0, 1.0])
    return x + wrong.start * np.cos(direction), y + wrong.start * np.sin(direction), yaw + turn


def _timed_step(localizer: Localizer, race: _core.Race, period: float) -> tuple[Estimate, float]:
    scan, state = race.scan(), race.measured()
    begin = time.thread_time_ns()
    estimate = localizer.step(scan, state, period)
    return estimate, 1e-3 * (time.thread_time_ns() - begin)


def percentiles(values: FloatArray) -> dict[str, float | None]:
    """p50, p95 and max; None without values."""
    if len(values) == 0:
        return {"p50": None, "p95": None, "max": None}
    p50, p95 = np.percentile(values, [50, 95])
    return {"p50": round(float(p50), 4), "p95": round(float(p95), 4), "max": round(float(values.max()), 4)}
