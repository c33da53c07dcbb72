"""Snapshots of single steps of a driver, for plots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.text import short_name
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import Setup
from firstlap.evaluation.replay.replay import batches, driver_for, prepared
from firstlap.mapping.contradictions import contradictions
from firstlap.recordings.laser import car_of
from firstlap.recordings.recording import Recording
from firstlap.sim.race import start_race
from firstlap.tracks.track import Track


@dataclass(frozen=True)
class StepSnapshot:
    """One step. Lengths in meters, in base_link; walls: the true ones, if known."""

    title: str
    subtitle: str
    driver: str
    trace: Mapping[str, Any]
    params: Mapping[str, Mapping[str, float]]
    car: Mapping[str, float]
    speed: float
    yaw_rate: float
    steering_angle: float
    walls: list[tuple[npt.NDArray[np.float64], bool]]
    outcome: str = ""
    remarks: tuple[str, ...] = ()


def explain_race(track: Track, setup: Setup, car: Car, at: float, *, seed: int, reverse: bool) -> StepSnapshot:
    """The step at `at` meters from the start line, or the last one if the race ended earlier.

    The car drives there, so its memory is as in a race. Raises InputError.
    """
    if reverse:
        track = track.reversed()
    if not 0.0 <= at <= 100.0 * track.length:
        furthest = 100.0 * track.length
        raise InputError(f"--at {at:g}: expected 0 to {furthest:.0f} m; a lap of {track.name} is {track.length:.1f} m")
    kind = driver_kind(setup.driver)
    driver = kind.make(setup.params(car.core), car, kind.prepare(track, setup, car, seed, None))
    running = start_race(track, driver, car, laps=int(at // track.length) + 2, seed=seed)
    active = running.advance()
    while active and _distance(running) < at:
        active = running.advance()
    measured = running.measured()
    outcome = "" if active else running.result()["outcome"]
    x, y, yaw = running.pose
    return StepSnapshot(
        title=f"{short_name(track.name)}, {_distance(running):.1f} m",
        subtitle=f"{'reverse, ' if reverse else ''}{setup.title}, car {car.name}, seed {seed}, "
        f"{running.time:.2f} s after the start",
        driver=setup.driver,
        trace=driver.trace,
        params=setup.params(car.core).values(),
        car=car.core.values()["geometry"],
        speed=measured.speed,
        yaw_rate=measured.yaw_rate,
        steering_angle=measured.steering_angle,
        walls=[(_to_car(wall, x, y, yaw), visible) for wall, visible in zip(track.walls, track.visible, strict=True)],
        outcome=outcome,
    )


def _distance(running: _core.Race) -> float:
    """Distance along the centerline since the start [m]."""
    s, length = running.s, running.track_length
    before_the_line = running.laps_done() == 0 and running.time < 1.0 and s > 0.5 * length
    return float(running.laps_done() * length + s - (length if before_the_line else 0.0))


def _to_car(points: npt.NDArray[np.float64], x: float, y: float, yaw: float) -> npt.NDArray[np.float64]:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray((points - (x, y)) @ np.array([[c, -s], [s, c]]))


def explain_recording(
    recording: Recording, setup: Setup, car: Car, index: int, *, mask_body: bool = True
) -> StepSnapshot:
    """The step on scan `index` of a recording (negative: from its end), after the scans before it.

    mask_body: as for `firstlap.evaluation.replay.replay.replay`. Raises InputError.
    """
    count = len(recording)
    if not -count <= index < count:
        raise InputError(f"{recording.source}: no scan {index}; expected 0 to {count - 1}")
    index %= count
    car = car_of(recording, car)
    setup, _, remarks = prepared(recording, setup, mask_body)
    handle = driver_for(setup, car)
    for _ in batches(recording.first(index + 1), handle.core):
        pass
    speed, yaw_rate, steering_angle = recording.states[index].tolist()
    return StepSnapshot(
        title=f"{recording.name}, scan {index}",
        subtitle=f"{recording.stamps[index]:.2f} s, {setup.title}, car {car.name}, "
        f"{len(recording.ranges[index])} beams, speed from {recording.sources['speed']}",
        driver=setup.driver,
        trace=handle.trace,
        params=setup.params(car.core).values(),
        car=car.core.values()["geometry"],
        speed=speed,
        yaw_rate=yaw_rate,
        steering_angle=steering_angle,
        walls=[],
        remarks=(*recording.remarks, *remarks, *contradictions(recording, car)),
    )
