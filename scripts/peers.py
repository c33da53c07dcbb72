"""Print the laps of our drivers beside those of f1tenth_benchmarks, on its tracks, as docs/peers.md.

Usage: scripts/peers.py AUT.yaml MCO.yaml [DRIVER:SETUP...] >docs/peers.md

The car is f1tenth_gym's, the speed limit 8 m/s, plans come at 25 Hz, as there.
"""

import sys
from pathlib import Path

from firstlap import _core
from firstlap.car_file import Car
from firstlap.compare import Entry, parse_entries
from firstlap.race import race
from firstlap.setup_file import Setup
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

DRIVERS = "local:sure,local:race,gap,gap:gap_arena,disparity,disparity:disparity_arena,pid,global"
LAPS, SEEDS, SPEED, RATE = 3, 3, 8.0, 25.0
PEERS = (
    ("Follow the gap", "no", "19.16 (1 of 3 crashed)", "35.04"),
    ("LocalMapPP (local map, constant width 1.8 m)", "no", "18.94", "33.80"),
    ("End-to-end TD3 (published)", "no", "19.94", "34.93"),
    ("Global raceline and pure pursuit, true pose", "yes", "16.85", "28.08 (published)"),
    ("Global MPCC, true pose", "yes", "16.96", "31.40"),
)
HEAD = f"""# Beside f1tenth_benchmarks

Printed by `scripts/peers.py AUT.yaml MCO.yaml`: f1tenth_gym's car, at most {SPEED:g} m/s, plans at {RATE:g} Hz,
{LAPS} laps from standstill, seeds 1 to {SEEDS}; the fastest flying lap of the races that finished, in seconds. The
lower rows are of BDEvan5/f1tenth_benchmarks (arXiv 2402.18558, 2401.17732), on its own simulator.

What differs: ours integrates by Runge-Kutta in 2.5 ms and tests the car's rectangle against the walls exactly, theirs
by Euler in 10 ms with a test of four corners on the map's pixels; theirs gives the true pose to map-based drivers. Our
setups are those for the default car (friction 0.75) with the speed limit raised to theirs: nothing was tuned to these
tracks, nor to the friction of 1.05 of this car; only `global` reads car and friction from the car's own parameters
(line and control use them), with the map of its own lap and no true pose. Their raceline plans with a friction of 0.9.

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


def main(arguments: list[str]) -> None:
    """Print the page."""
    car = gym_at_25_hz()
    tracks = [load_track(path) for path in arguments[:2]]
    entries: list[Entry] = parse_entries(",".join(arguments[2:]) or DRIVERS, car)
    print(HEAD, end="")
    for entry in entries:
        limit = "line.speed_max" if entry.needs_map else "v_max"
        setup = entry.setup.with_values({limit: SPEED})
        cells = [cell(track, setup, car) for track in tracks]
        print(f"| `{entry.label}` | {'yes' if entry.needs_map else 'no'} | {' | '.join(cells)} |", flush=True)
    for row in PEERS:
        print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    if len(sys.argv) < 3 or not all(Path(path).is_file() for path in sys.argv[1:3]):
        sys.exit("usage: scripts/peers.py AUT.yaml MCO.yaml [DRIVER:SETUP...]")
    main(sys.argv[1:])
