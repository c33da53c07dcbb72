"""firstlap bench"""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    SetOption,
    SetupOption,
    chosen_setup,
    console,
    print_json,
)
from firstlap.common.text import short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import LOCAL
from firstlap.evaluation.bench import bench as run_bench
from firstlap.tracks.library import load_track

ROWS = {
    "step_us": "a step on one scan",
    "scan_us": "a noise-free scan of the lidar",
    "reference_us": "reference: beams to points by cos and sin",
}


def bench(
    track: Annotated[str, typer.Argument(metavar="TRACK", help="As for `race`.")] = "arena",
    setup: SetupOption = None,
    changes: SetOption = None,
    car: CarOption = "default",
    as_json: JsonOption = False,
) -> int:
    """Time a step, a scan and a whole race on one core, with a reference in the same run."""
    found = {
        "version": __version__,
        **run_bench(load_track(track), chosen_setup(setup, changes, LOCAL), load_car(car)),
    }
    if as_json:
        print_json(found)
        return 0
    table = Table(title=f"{short_name(found['track'])}, setup {found['setup']}, {found['scans']} scans")
    table.add_column("µs")
    for heading in ("p50", "p99", "max", "p50 / reference"):
        table.add_column(heading, justify="right")
    for key, label in ROWS.items():
        times = found[key]
        ratio = times["p50"] / found["reference_us"]["p50"]
        table.add_row(label, *(f"{times[name]:.1f}" for name in ("p50", "p99", "max")), f"{ratio:.2f}")
    out = console()
    out.print(table)
    out.print(f"a whole race ran at {found['realtime_factor']:.0f} times real time")
    return 0
