"""Injects faults into the map-based driver at many places of a lap and counts contacts. Exit code 1 if there was one.

MODE: lost (no pose from then on), kidnap (the filter is displaced by 0.5 m), wall (a wall across the track that is not
in the map; behind a curve, the car may see it too late to stop), box (a box of 1 m width appears on the car's line when
its front is --sight shortest stopping distances away, see `robustness.stopping_distance`; it counts from the first scan
that shows it, because walls may occlude it). Needs the extra `global`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from firstlap.config.car_file import Car, load_car
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.drivers.global_driver.guard import returns
from firstlap.evaluation.robustness.cases import RUN_UP, Box, boxes, stopping_distance
from firstlap.mapping.poses import between, transform
from firstlap.sim.race import race, start_race
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

KIDNAP, HALF_WALL, AFTER = 0.5, 1.2, 3.5
BOX_WIDTH, BOX_LENGTH, TOUCH = 1.0, 0.2, 0.06
FACTOR = 1.25


def walled(track: Track, s: float) -> Track:
    """The track with a wall across it."""
    x, y, yaw = track.start_pose(s)
    across = np.array([[-np.sin(yaw), np.cos(yaw)]]) * np.array([[-HALF_WALL], [HALF_WALL]]) + np.array([x, y])
    return replace(
        track,
        walls=[*track.walls, across],
        sides=[*track.sides, "obstacle"],
        visible=[*track.visible, True],
        solid=[*track.solid, True],
    )


def let_down(driver: Any, mode: str, direction: float) -> None:
    """The fault modes."""
    if mode == "lost":
        driver._pose = lambda *_: None
    elif mode == "kidnap":
        driver.localizer.core.displace(KIDNAP * np.cos(direction), KIDNAP * np.sin(direction), 0.0)


def drive(track: Track, setup: Setup, car: Car, prepared: Preparation, mode: str, at: float, direction: float) -> Any:
    """A race with the fault at `at` [m] of the first lap: its result, and the speed [m/s] at that time."""
    handle = driver_kind("global").make(setup.params(car.core), car, prepared)
    race = start_race(walled(track, at) if mode == "wall" else track, handle, car, laps=1, seed=2)
    end, then = np.inf, 0.0
    while race.advance(1) and race.time < end:
        if mode == "wall":
            then = max(then, race.state().speed)
        elif end == np.inf and race.time > 0.5 and at <= race.s < at + 1.0:
            let_down(handle.driver, mode, direction)  # type: ignore[attr-defined]
            end, then = race.time + (AFTER if mode == "lost" else np.inf), race.state().speed
            mode = "done" if mode == "kidnap" else mode
    return race.result(), then


def on_box(race_now: Any, driver: Any, box: Any) -> bool:
    """Whether the last scan has enough returns on the box (x, y, yaw of its center)."""
    seen = driver.seen
    near = returns(seen["scan"], *race_now[1:], driver.guard.body, seen["scan"].range_max)
    local = transform(between(np.array(box), np.zeros(3)), transform(np.array(race_now[0]), near))
    inside = (np.abs(local[:, 0]) < 0.5 * BOX_LENGTH + TOUCH) & (np.abs(local[:, 1]) < 0.5 * BOX_WIDTH + TOUCH)
    return bool(inside.sum() >= driver.parts.guard.blocking)


def to_box(track: Track, setup: Setup, car: Car, prepared: Preparation, box: Box) -> tuple[Any, float, float, float]:
    """A drive from a run-up to a box and a stop: its result; and, when the box first was in a scan, the speed, the
    distance from the car's front to it, and the shortest stopping distance [m/s, m, m]."""
    handle = driver_kind("global").make(setup.params(car.core), car, prepared)
    options = {"start_s": box.s - RUN_UP, "obstacle_at": RUN_UP, "obstacle_offset": box.offset, "stuck_time": 0.5}
    options |= {"obstacle_sight": box.sight, "obstacle_width": BOX_WIDTH, "obstacle_length": BOX_LENGTH}
    running = start_race(track, handle, car, laps=1, seed=2, options=options)
    nose = handle.driver.guard.body.front  # type: ignore[attr-defined]
    then: tuple[float, float, float] | None = None
    while running.advance(1):
        state, pose = running.state(), running.pose
        box_now = running.result()["obstacle"] if then is None else None
        place = (box_now.x, box_now.y, box_now.yaw) if box_now else (np.inf, np.inf, 0.0)
        if box_now and on_box((pose, state.speed, state.yaw_rate), handle.driver, place):  # type: ignore[attr-defined]
            way = np.hypot(place[0] - pose[0], place[1] - pose[1]) - nose - 0.5 * BOX_LENGTH
            then = (
                state.speed,
                float(way),
                stopping_distance(car, state.speed, abs(state.speed * state.yaw_rate)),
            )
    return running.result(), *(then or (0.0, 0.0, 0.0))


def check_boxes(track: Track, setup: Setup, car: Car, prepared: Preparation, given: argparse.Namespace) -> int:
    """Prints one row per place; returns the number of contacts with boxes that were visible early enough."""
    reference = race(track, setup, car, laps=2, preparation=prepared)
    contacts = runs = 0
    print("at m   m/s  in view at m  shortest stop m  times   outcome  end m/s  clearance m")
    for box in list(boxes(reference, car, given.places, given.sight))[1::3]:
        result, speed, way, least = to_box(track, setup, car, prepared, box)
        counts = way >= FACTOR * least
        runs += counts
        contacts += counts and result["contact"] is not None
        times = way / least if least else float("nan")
        print(
            f"{box.s:5.1f}  {speed:4.1f}   {way:10.2f}   {least:14.2f}  {times:5.2f}   {result['outcome']:8s}  "
            f"{result['path']['speed'][-1]:5.2f}    {result['obstacle']['clearance']:5.2f}",
            flush=True,
        )
    print(f"{contacts} contacts of {runs} in view from {FACTOR:g} shortest stopping distances or farther")
    return 1 if contacts else 0


def main() -> int:
    """Prints one row per place."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("track")
    parser.add_argument("mode", choices=("lost", "kidnap", "wall", "box"))
    parser.add_argument("--car", default="default")
    parser.add_argument("--places", type=int, default=18)
    parser.add_argument("--sight", type=float, default=1.5, help="shortest stopping distances, for box")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    given = parser.parse_args()
    track, car, setup = load_track(given.track), load_car(given.car), choose_setup("global", None)
    setup = setup.with_assignments(given.set)
    prepared = driver_kind("global").prepare(track, setup, car, 1, None)
    if given.mode == "box":
        return check_boxes(track, setup, car, prepared, given)
    rng = np.random.default_rng(1)
    contacts = 0
    print("at m   m/s    outcome     end m/s")
    for at in np.linspace(2.5, track.length - 2.5, given.places):
        result, then = drive(track, setup, car, prepared, given.mode, float(at), rng.uniform(-np.pi, np.pi))
        contacts += result["contact"] is not None
        print(f"{at:5.1f}  {then:4.1f}   {result['outcome']:10s}  {result['path']['speed'][-1]:.2f}", flush=True)
    print(f"{contacts} contacts at {given.places} places")
    return 1 if contacts else 0


if __name__ == "__main__":
    sys.exit(main())
