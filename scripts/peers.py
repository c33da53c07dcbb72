"""Print the laps of our drivers beside those of f1tenth_benchmarks, on its tracks, as docs/peers.md.

Usage: scripts/peers.py AUT.yaml MCO.yaml [--tuned AUT_SETUP.yaml MCO_SETUP.yaml] >docs/peers.md

The car is f1tenth_gym's, the speed limit 8 m/s, plans come at 25 Hz, as there. --car prints that car's file instead.
"""

import argparse

import yaml

from firstlap import _core
from firstlap.car_file import Car
from firstlap.compare import Entry, parse_entries
from firstlap.race import race
from firstlap.setup_file import Setup, load_setup
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

DRIVERS = "local:sure,local:race,gap,gap:gap_arena,disparity,disparity:disparity_arena,pid,global"
LAPS, SEEDS, SPEED, RATE = 3, 3, 8.0, 25.0
FRICTION = 0.9
"""That the peers' raceline is planned with."""
GRAVITY = 9.81
PEERS = (
    ("Follow the gap", "no", "19.16 (1 of 3 crashed)", "35.04"),
    ("LocalMapPP (local map, constant width 1.8 m)", "no", "18.94", "33.80"),
    ("End-to-end TD3 (published)", "no", "19.94", "34.93"),
    ("Global raceline and pure pursuit, true pose", "yes", "16.85", "28.08 (published)"),
    ("Global MPCC, true pose", "yes", "16.96", "31.40"),
)
HEAD = f"""# Beside f1tenth_benchmarks

Printed by `scripts/peers.py AUT.yaml MCO.yaml --tuned AUT_SETUP.yaml MCO_SETUP.yaml`: f1tenth_gym's car, at most
{SPEED:g} m/s, plans at {RATE:g} Hz, {LAPS} laps from standstill, seeds 1 to {SEEDS}; the fastest flying lap of the
races that finished, in seconds. The lower rows are of BDEvan5/f1tenth_benchmarks (arXiv 2402.18558, 2401.17732), on
its own simulator.

What differs: ours integrates by Runge-Kutta in 2.5 ms and tests the car's rectangle against the walls exactly, theirs
by Euler in 10 ms with a test of four corners on the map's pixels; theirs gives the true pose to map-based drivers. Our
setups are those for the default car (friction 0.75) with the speed limit raised to theirs, tuned neither to these
tracks nor to the friction of 1.05 of this car; but `global` reads car and friction from the car's own parameters
(line and control use them), with the map of its own lap and no true pose, and `local`, tuned, has a setup for each of
the two, found in three minutes and raced here in the same conditions as all others:

```sh
scripts/peers.py --car >gym25.yaml
firstlap tune AUT.yaml --car gym25.yaml --budget 3m --no-validate --name aut     # and MCO.yaml, likewise
```

Their raceline plans with a friction of {FRICTION:g}, and so does `local`, tuned, here: this car's tyres are linear,
which a search finds out, and would carry it round faster than any real ones.

| driver | needs a map | aut | mco |
|---|---|---|---|
"""


def gym_at_25_hz() -> Car:
    """f1tenth_gym's car with a scan per plan."""
    core = _core.Car.preset("gym")
    core.set("lidar", "rate", RATE)
    return Car("gym, 25 Hz", core)


def cell(track: Track, setup: Setup, car: Car) -> str:
    """Fastest flying lap, and how many races were lost."""
    results = [race(track, setup, car, laps=LAPS, seed=seed) for seed in range(1, SEEDS + 1)]
    laps = [lap.time for result in results if result.finished for lap in result.laps if not lap.standing]
    lost = sum(not result.finished for result in results)
    text = f"{min(laps):.2f}" if laps else "–"
    return text + (f" ({lost} of {SEEDS} not finished)" if lost else "")


def at_limit(setup: Setup, limit: str) -> Setup:
    """With the peers' speed limit."""
    return setup.with_values({limit: SPEED})


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--car", action="store_true")
    parser.add_argument("--tuned", nargs=2, metavar="SETUP", help="of local, for each of the maps")
    parser.add_argument("maps", nargs="*", metavar="MAP")
    parser.add_argument("--drivers", default=DRIVERS)
    arguments = parser.parse_args()
    car = gym_at_25_hz()
    if arguments.car:
        print(yaml.safe_dump(car.core.values()), end="")
        return
    if len(arguments.maps) != 2:
        parser.error("expected the maps AUT.yaml and MCO.yaml")
    tracks = [load_track(path) for path in arguments.maps]
    entries: list[Entry] = parse_entries(arguments.drivers, car)
    print(HEAD, end="")
    if arguments.tuned:
        grip = {"a_y_max": FRICTION * GRAVITY}
        setups = [at_limit(load_setup(path), "v_max").with_values(grip) for path in arguments.tuned]
        cells = [cell(track, setup, car) for track, setup in zip(tracks, setups, strict=True)]
        print(f"| `local`, tuned | no | {' | '.join(cells)} |", flush=True)
    for entry in entries:
        setup = at_limit(entry.setup, "line.speed_max" if entry.needs_map else "v_max")
        cells = [cell(track, setup, car) for track in tracks]
        print(f"| `{entry.label}` | {'yes' if entry.needs_map else 'no'} | {' | '.join(cells)} |", flush=True)
    for row in PEERS:
        print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    main()
