"""Prints the tables of docs/global-map.md: accuracy of the maps, and of the localization in a race on them.

Each track is mapped in one slow lap. Then the setup `race` is driven, and the localizer runs on that map: undisturbed,
with
an error of 2 m and 45 degrees at the start, and displaced by 0.5 m every three seconds. Maps of other teams are read
from
--maps.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.drivers.mapping_drive import map_track
from firstlap.evaluation.localization import Disturbance, follow
from firstlap.evaluation.map_accuracy import check_map, true_start
from firstlap.mapping.occupancy_map import OccupancyMap
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

WRONG = Disturbance(start=2.0, heading=math.radians(45.0))
KIDNAPPED = Disturbance(kidnap=0.5, every=3.0)
SEEDS = 4


def specs(maps: Path | None) -> list[str]:
    """Our tracks, then the maps in the folders below `maps`."""
    others = sorted(maps.glob("*/*.yaml")) if maps else []
    return [*list_tracks(), *(str(path) for path in others)]


def map_row(track: Track) -> tuple[str, OccupancyMap]:
    """A row of the first table, and the map."""
    car = load_car("default")
    result = map_track(track)
    error = check_map(result.map, track, true_start(track, car))
    cells = [
        track.name,
        f"{track.length:.1f}",
        f"{result.mapper.traveled:.1f}",
        f"{1000 * error.rms:.0f}",
        f"{1000 * error.rms_start:.0f}",
        f"{1000 * error.p95:.0f}",
        f"{100 * error.complete:.1f}",
    ]
    return "| " + " | ".join(cells) + " |", result.map


def follow_row(track: Track, known: OccupancyMap, setup: str) -> str:
    """A row of the second table."""
    plain = _follow(track, known, setup, 1, Disturbance())
    starts = [_follow(track, known, setup, seed, WRONG, scans=240) for seed in range(1, SEEDS + 1)]
    found = [run["found_after"] for run in starts if run["found_after"] is not None]
    moved = _follow(track, known, setup, 1, KIDNAPPED)
    position, heading, step = plain["position"], plain["heading"], plain["step_us"]
    cells = [
        track.name + ("" if plain["outcome"] == "finished" else f" ({plain['outcome']})"),
        f"{plain['mean_speed']:.1f}/{plain['top_speed']:.1f}",
        f"{100 * position['p50']:.1f}/{100 * position['p95']:.1f}/{100 * position['max']:.1f}",
        f"{heading['p50']:.2f}/{heading['p95']:.2f}",
        f"{100 * plain['lost']:.1f}",
        f"{1e-3 * step['p50']:.2f}/{1e-3 * step['p99']:.2f}",
        f"{len(found)}/{SEEDS}, {max(found, default=math.nan):.1f} s",
        f"{moved['recovered']}/{moved['kidnapped']}, {moved['recovered_after'] or 0:.1f} s",
    ]
    return "| " + " | ".join(cells) + " |"


def _follow(
    track: Track, known: OccupancyMap, setup: str, seed: int, wrong: Disturbance, scans: int | None = None
) -> dict[str, Any]:
    car = load_car("default")
    return follow(track, known, load_setup(setup), car, laps=2, seed=seed, disturbance=wrong, scans=scans).to_dict()


def main() -> int:
    """Prints both tables, the first one row by row."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--maps", type=Path, help="a folder of folders with ROS maps")
    parser.add_argument("--setup", default="race")
    parser.add_argument("tracks", nargs="*", help="default: all tracks of the package and all of --maps")
    arguments = parser.parse_args()
    follows = []
    print("| track | length m | driven m | rms mm | at the start mm | p95 mm | walls found % |")
    print("|---|---|---|---|---|---|---|")
    for spec in arguments.tracks or specs(arguments.maps):
        track = load_track(spec)
        row, known = map_row(track)
        print(row, flush=True)
        follows.append(follow_row(track, known, arguments.setup))
    print("\n| track | mean/top m/s | position cm p50/p95/max | heading ° p50/p95 | lost % | step ms p50/p99 "
          "| wrong start found | kidnapped recovered |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|")
    print("\n".join(follows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
