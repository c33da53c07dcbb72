"""Races one setup on many tracks, one race at a time; an interrupted survey is resumed.

Prints the JSON of `firstlap survey --json`, for scripts/opponents_page.py, with two additional entries per track:
`compute` (p50, p99 of a step in microseconds) and `statuses` (steps per status). For drivers that need minutes per
track: a stored race is only repeated if something that it depends on has changed. Seed 1 of every track comes first.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import time
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from firstlap import __version__
from firstlap.cli.survey import expand
from firstlap.common.cache import cache_folder, hash_of_code
from firstlap.common.files import write_whole
from firstlap.config.car_file import Car, load_car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import Setup, load_setup
from firstlap.evaluation.survey import TrackSummary
from firstlap.sim.race import Lap, RaceResult, race
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track
from firstlap.tracks.track_hash import track_hash

SOURCES = ("control", "drivers", "localization", "mapping", "planning", "sim", "tracks", "config/driver_kind.py")
"""The parts of the Python package that a race depends on, in addition to the core."""


def key_of(track: Track, setup: Setup, car: Car, given: argparse.Namespace, seed: int) -> str:
    """The key of a race in the store: a hash of everything that it depends on."""
    said = [track_hash(track), setup.driver, setup.params(car.core).values(), car.core.values(), given.laps, seed]
    text = json.dumps([*said, given.latency, given.code], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:40]


def kept(result: RaceResult) -> dict[str, Any]:
    """The stored result of a race."""
    status = Counter(result.path["status"].tolist())
    return {
        **result.to_dict(),
        "time": result.time,
        "s": float(result.path["s"][-1]) if len(result.path["s"]) else 0.0,
        "speed": float(result.path["speed"][-1]) if len(result.path["speed"]) else 0.0,
        "statuses": {str(name): count for name, count in sorted(status.items())},
    }


def raced(
    spec: str, track: Track, reverse: bool, seed: int, setup: Setup, car: Car, given: Any
) -> dict[str, Any] | None:
    """A race, from the store or driven now; None if it must not be driven."""
    way = track.reversed() if reverse else track
    place = given.store / f"{key_of(way, setup, car, given, seed)}.json"
    try:
        return dict(json.loads(place.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        if given.stored:
            return None
    begin = time.process_time()
    before = driver_kind(setup.driver).prepare(way, setup, car, 1, None)
    result = race(way, setup, car, laps=given.laps, seed=seed, latency=given.latency, preparation=before)
    found = {**kept(result), "direction": "reverse" if reverse else "forward"}
    write_whole(place, lambda name: Path(name).write_text(json.dumps(found), encoding="utf-8"))
    laps = [lap["time"] for lap in found["laps"][1:]] or [float("nan")]
    clear = min((lap["min_clearance"] for lap in found["laps"]), default=float("nan"))
    print(
        f"{Path(spec).stem:14s} {found['direction']:8s} seed {seed}  {found['outcome']:9s} {len(found['laps']):2d} laps"
        f" best {min(laps):6.2f}  clear {clear:5.3f}  at {found['s']:6.1f} m {found['speed']:4.1f} m/s  "
        f"p99 {1e-3 * (found['compute']['p99'] or 0.0):5.2f} ms  {found['statuses']}  "
        f"took {time.process_time() - begin:.0f} s",
        file=sys.stderr,
        flush=True,
    )
    return found


def summary(spec: str, track: Track, races: list[dict[str, Any]]) -> dict[str, Any]:
    """A row as in `firstlap survey --json`, with `compute` and `statuses`."""
    row = TrackSummary(spec, track.length)
    for found in races:
        facts = {**found, "laps": [Lap(**lap) for lap in found["laps"]], "path": {"s": np.array([found["s"]])}}
        row.results.append(SimpleNamespace(**facts, finished=found["outcome"] == "finished"))  # type: ignore[arg-type]
    steps: Counter[str] = Counter()
    for found in races:
        steps.update(found["statuses"])
    compute = {name: float(np.median([found["compute"][name] for found in races])) for name in ("p50", "p99")}
    return {**row.to_dict(), "compute": compute, "statuses": dict(steps)}


def main() -> int:
    """Runs the missing races and prints the result. Exit code 1 if a race did not finish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tracks", nargs="+", help="as for `firstlap survey`")
    parser.add_argument("--setup", default="global")
    parser.add_argument("--car", default="default")
    parser.add_argument("--laps", type=int, default=10)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--both", action="store_true", help="both directions")
    parser.add_argument("--latency", default="measured")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--store", type=Path, default=cache_folder("everywhere"))
    parser.add_argument("--stored", action="store_true", help="only print what is in the store")
    given = parser.parse_args()
    given.code = hash_of_code(SOURCES)
    given.store.mkdir(parents=True, exist_ok=True)
    setup, car = load_setup(given.setup), load_car(given.car)
    setup = setup.with_assignments(given.set) if given.set else setup
    tracks = {spec: load_track(spec) for spec in expand(given.tracks)}
    races: dict[str, list[dict[str, Any]]] = {spec: [] for spec in tracks}
    for reverse in (False, True) if given.both else (False,):
        for seed in range(1, given.seeds + 1):
            for spec, track in tracks.items():
                found = raced(spec, track, reverse, seed, setup, car, given)
                races[spec] += [found] if found else []
    rows = [summary(spec, track, races[spec]) for spec, track in tracks.items() if races[spec]]
    runs, finished = (sum(row[name] for row in rows) for name in ("runs", "finished"))
    printed = {
        "version": __version__,
        "driver": setup.driver,
        "setup": setup.name,
        "set": {f"{section}.{name}": value for (section, name), value in setup.changed.items()},
        "car": car.name,
        "options": {},
        "latency": given.latency,
        "code": given.code,
        "laps": given.laps,
        "runs": runs,
        "finished": finished,
        "success_rate": finished / runs if runs else None,
        "tracks": rows,
        "seeds": given.seeds,
        "both": given.both,
        "interrupted": False,
    }
    print(json.dumps(printed, indent=2))
    return 0 if finished == runs else 1


if __name__ == "__main__":
    sys.exit(main())
