"""Compares the lap time of our racing lines with an independent nonlinear program (casadi, ipopt).

Exit code 1 if one differs by more than 1 % or the program is not solved. Needs the extra `global`. Takes about a minute
per track.
"""

from __future__ import annotations

import argparse
import sys
import time

from firstlap.config.car_file import load_car
from firstlap.planning.raceline.line import make_line
from firstlap.planning.raceline.params import LineParams, limits_of
from firstlap.planning.raceline.path import resampled
from firstlap.planning.raceline.reference import reference_line
from firstlap.planning.raceline.velocity import profile
from firstlap.tracks.library import load_track

TRACKS = ("arena", "slalom", "corners")
ALLOWED = 0.01


def main() -> int:
    """Prints one row per track."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tracks", nargs="*", default=TRACKS)
    parser.add_argument("--car", default="default")
    arguments = parser.parse_args()
    car, params = load_car(arguments.car), LineParams()
    limits = limits_of(car, params)
    print("track        ours s    reference s   its line, our profile s   ours to reference   took s   solver")
    worst = 0.0
    for name in arguments.tracks:
        print(f"{name} ...", end="\r", file=sys.stderr)
        track = load_track(name)
        ours = make_line(track, car, params)
        begin = time.perf_counter()
        reference = reference_line(track, car, params)
        took = time.perf_counter() - begin
        path = resampled(reference.points, params.spacing)
        again = profile(path.curvature, path.step, limits).time
        off = ours.lap_time / reference.time - 1.0
        solved = reference.status == "Solve_Succeeded"
        worst = max(worst, abs(off) if solved else float("inf"))
        print(
            f"{name:12s} {ours.lap_time:6.3f}    {reference.time:11.3f}   {again:23.3f}   {100 * off:+15.2f} %"
            f"   {took:6.1f}   {reference.status}"
        )
    return 0 if worst <= ALLOWED else 1


if __name__ == "__main__":
    sys.exit(main())
