"""Drives racing lines in the simulator with the true pose; --noise: with pose errors of 3 cm, 1 degree and 20 ms.

One row per track and seed: laps, clearance, and CPU time of a control step in milliseconds. Exit code 1 if a race did
not finish. Needs the extra `global`.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import replace

import numpy as np

from firstlap import _core
from firstlap.config.car_file import Car, load_car
from firstlap.config.table import from_values
from firstlap.control.mpc.controller import Controller
from firstlap.control.mpc.params import MPC_FIELDS, MpcParams
from firstlap.control.mpc.pose_driver import PoseDriver, PoseErrors, worst_errors
from firstlap.planning.raceline.line import RaceLine, make_line
from firstlap.planning.raceline.params import LINE_FIELDS, LineParams
from firstlap.sim.lidar import core_track
from firstlap.sim.race import OPTION_FIELDS
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

LATENCY = 0.005
"""[s] Delay from measurement to command in these races."""
FEW_BEAMS = 3
"""The controller uses no scan, so none is simulated."""


def drive(
    track: Track, line: RaceLine, car: Car, params: MpcParams, laps: int, seed: int, errors: PoseErrors
) -> tuple[dict, PoseDriver]:
    """Runs a race; returns its result and its driver."""
    options = _core.RaceOptions()
    for name, value in {"laps": laps, "compute_latency": LATENCY}.items():
        field = OPTION_FIELDS.find(name, "options")
        options.set(field.section, field.name, value)
    options.seed = seed
    driver = PoseDriver(Controller(line, track, car, params), errors, seed)
    core = _core.CallbackDriver(driver)
    driver.race = race = _core.Race(core_track(track), car.core, core, options)
    while race.advance(40):
        pass
    driver.race = None
    return race.result(), driver


def row(name: str, seed: int, line: RaceLine, result: dict, driver: PoseDriver) -> str:
    """A row of the table."""
    times = [lap["time"] for lap in result["laps"]]
    flying = times[1:] or times or [float("nan")]
    clear = min((lap["min_clearance"] for lap in result["laps"]), default=float("nan"))
    p50, p99 = np.percentile(1e3 * np.array(driver.times), [50, 99])
    statuses = Counter(result["path"]["status"].tolist())
    other = sum(count for status, count in statuses.items() if status != 0)
    where = f" s={result['contact']['s']:.1f}" if result["contact"] else ""
    return (
        f"{name:14s} {seed:4d}   {result['outcome']:9s} {len(times):4d}   {min(flying):6.2f} {np.median(flying):6.2f}"
        f" {line.lap_time:6.2f}   {clear:6.3f}   {p50:5.2f} {p99:5.2f}   {other:5d}{where}"
    )


def main() -> int:
    """Prints one row per track and seed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tracks", nargs="*", help="as for `firstlap race`; default: all tracks of the package")
    parser.add_argument("--car", default="default")
    parser.add_argument("--laps", type=int, default=10)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--noise", action="store_true")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="parameter of the controller")
    parser.add_argument("--line", action="append", default=[], metavar="NAME=VALUE", help="parameter of the line")
    given = parser.parse_args()
    mpc = dict(MPC_FIELDS.parse_assignment(text) for text in given.set)
    lines = dict(LINE_FIELDS.parse_assignment(text) for text in given.line)
    params = from_values(MpcParams, "mpc", {(field.section, field.name): value for field, value in mpc.items()})
    # Plans must not be late on a busy machine; the table shows the step time.
    params = replace(params, time_limit=1.0)
    shape = from_values(LineParams, "line", {(field.section, field.name): value for field, value in lines.items()})
    car = load_car(given.car)
    car.core.set("lidar", "beams", FEW_BEAMS)
    errors = worst_errors() if given.noise else PoseErrors()
    print("track          seed   outcome   laps   best s median line s   clear m   ms p50   p99   not ok")
    bad = 0
    for spec in given.tracks or list_tracks():
        track = load_track(spec)
        line = make_line(track, car, shape)
        for seed in range(1, given.seeds + 1):
            result, driver = drive(track, line, car, params, given.laps, seed, errors)
            print(row(track.name, seed, line, result, driver), flush=True)
            bad += result["outcome"] != "finished"
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
