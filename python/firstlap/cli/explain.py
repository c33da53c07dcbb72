"""firstlap explain"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from firstlap.car_file import load_car
from firstlap.cli.common import CarOption, DriverOption, SetOption, SetupOption, chosen_setup, console
from firstlap.errors import InputError
from firstlap.output import check_writable
from firstlap.tracks.library import load_track


def explain(
    track: Annotated[str | None, typer.Argument(metavar="[TRACK]", help="As of `race`; the car drives there.")] = None,
    at: Annotated[float, typer.Option("--at", metavar="METRES", help="Way from the start line.")] = 0.0,
    scan: Annotated[Path | None, typer.Option("--scan", metavar="FILE", help="An .npz recording of scans.")] = None,
    index: Annotated[int, typer.Option("--index", help="Which scan of the recording.")] = 0,
    speed: Annotated[float, typer.Option("--speed", help="m/s, for a recording without.")] = 1.0,
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of everything random.")] = 1,
    reverse: Annotated[bool, typer.Option("--reverse", help="Drive the other way round.")] = False,
    car: CarOption = "default",
    plot: Annotated[Path, typer.Option("--plot", metavar="FILE", help="Where the picture goes.")] = Path("explain.png"),
) -> int:
    """Draw one step of a driver: what it saw, what it made of it, and why it steers as it does."""
    from firstlap.explain import explain_race, explain_scan
    from firstlap.explain_plot import plot_moment
    from firstlap.plot import PICTURES

    if (track is None) == (scan is None):
        raise InputError("expected either TRACK with --at METRES, or --scan FILE")
    check_writable(plot, PICTURES)
    chosen = chosen_setup(setup, changes, driver)
    loaded_car = load_car(car)
    if scan is not None:
        moment = explain_scan(scan, chosen, loaded_car, index, speed)
    else:
        moment = explain_race(load_track(str(track)), chosen, loaded_car, at, seed=seed, reverse=reverse)
    plot_moment(moment, plot)
    out = console()
    if moment.outcome:
        out.print(f"[yellow]the race ended before that: {moment.outcome}; this is its last step[/]")
    out.print(escape(f"picture: {plot}"), soft_wrap=True)
    return 0
