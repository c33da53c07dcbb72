"""Evaluates perception in a simulated race against the true walls in every scan."""

from __future__ import annotations

from collections.abc import Callable

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.drivers.racer import Racer
from firstlap.evaluation.perception.detections import Detection
from firstlap.evaluation.perception.ground_truth import GroundTruth
from firstlap.evaluation.perception.metrics import Perception
from firstlap.sim.race import start_race
from firstlap.tracks.track import Track


def measure(
    track: Track,
    setup: Setup,
    car: Car,
    *,
    laps: int = 1,
    seed: int = 1,
    on_progress: Callable[[_core.Race], object] | None = None,
    each: Callable[[Detection, tuple[float, float, float], Perception], object] | None = None,
) -> tuple[Perception, str]:
    """Races `track` in its direction and evaluates every scan; also returns the outcome of the race.

    on_progress: called about once per simulated second; an exception from it ends the race. each: called after every
    scan. Raises InputError.
    """
    racer = Racer(setup, car)
    running = start_race(track, racer, car, laps=laps, seed=seed)
    perception = Perception(GroundTruth.of(track))
    front = setup.params(car.core).values()["car"]["wheelbase"]
    time = running.time
    while running.advance():
        seen = Detection.of(racer.trace, front)
        perception.add(seen, running.pose, running.time - time)
        time = running.time
        if each:
            each(seen, running.pose, perception)
        if on_progress and perception.scans % 40 == 0:
            on_progress(running)
    return perception, str(running.result()["outcome"])
