"""firstlap localize"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap import _core
from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LapsOption,
    SetupOption,
    TrackArgument,
    chosen_setup,
    console,
    print_json,
    progress_bar,
)
from firstlap.common.text import UNKNOWN, counted, short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import load_car


def localize(
    track: TrackArgument,
    known: Annotated[
        Path | None, typer.Option("--map", metavar="MAP", help="The map to find it on; default: made by a slow lap.")
    ] = None,
    setup: SetupOption = "race",
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Change one parameter of localization; repeatable."),
    ] = None,
    laps: LapsOption = 3,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of everything random.")] = 1,
    car: CarOption = "default",
    wrong_start: Annotated[
        float, typer.Option("--wrong-start", min=0, max=10, metavar="M", help="Start wrong by this, any direction.")
    ] = 0.0,
    wrong_heading: Annotated[
        float, typer.Option("--wrong-heading", min=0, max=180, metavar="DEG", help="And turned by this, either way.")
    ] = 0.0,
    kidnap: Annotated[
        float, typer.Option("--kidnap", min=0, max=10, metavar="M", help="Set the car elsewhere, again and again.")
    ] = 0.0,
    every: Annotated[float, typer.Option("--every", min=0.5, max=1000, metavar="S", help="So often.")] = 3.0,
    as_json: JsonOption = False,
) -> int:
    """Measure how well the particle filter follows a racing car. Exits 1 when the race or the filter fails."""
    from firstlap.drivers.mapping_drive import map_track
    from firstlap.evaluation.localization import Disturbance, follow
    from firstlap.localization.localizer import localizer_params
    from firstlap.mapping.occupancy_map import read_map
    from firstlap.tracks.library import load_track

    params, chosen, chosen_car = localizer_params(changes), chosen_setup(setup, None), load_car(car)
    found_map = read_map(known) if known else None
    loaded = load_track(track)
    with progress_bar() as bar:
        task = bar.add_task("mapping lap", total=1.0)

        def look(what: str, done: float, total: float) -> None:
            bar.update(task, description=what, completed=done, total=total)

        if found_map is None:
            found_map = map_track(loaded, None, chosen_car, seed=seed, look=look).map

        def watch(race: _core.Race) -> None:
            look("following", race.laps_done() * race.track_length + race.s, laps * race.track_length)

        followed = follow(
            loaded,
            found_map,
            chosen,
            chosen_car,
            laps=laps,
            seed=seed,
            params=params,
            disturbance=Disturbance(wrong_start, math.radians(wrong_heading), kidnap, every),
            look=watch,
        )
    found = {
        "version": __version__,
        "track": loaded.name,
        "map": str(known or "made by a slow lap"),
        "setup": chosen.name,
        "car": chosen_car.name,
        "seed": seed,
        "wrong_start": wrong_start,
        "wrong_heading": wrong_heading,
        "kidnap": kidnap,
        **followed.to_dict(),
    }
    if as_json:
        print_json(found)
    else:
        _print(found)
    return 0 if found["outcome"] == "finished" and not found["lost_at_end"] else 1


def _print(found: dict[str, Any]) -> None:
    laps = counted(found["laps"], "lap")
    table = Table(
        title=escape(
            f"{short_name(found['track'])}, setup {found['setup']}, {laps}, {found['mean_speed']:.2f} m/s on average"
        )
    )
    for heading in ("", "p50", "p95", "max"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, unit, digits in (("position", "m", 3), ("heading", "°", 2), ("step_us", "µs", 0)):
        row = found[name]
        values = [UNKNOWN if row[key] is None else f"{row[key]:.{digits}f} {unit}" for key in ("p50", "p95", "max")]
        table.add_row("a step" if name == "step_us" else f"{name} off by", *values)
    out = console()
    out.print(table)
    if found["outcome"] != "finished":
        out.print(f"[bold red]the race ended in {found['outcome'].replace('_', ' ')}[/]")
    out.print(f"a step took {found['step_us']['p99']:.0f} µs (p99, processor time)")
    out.print(f"lost in {100 * found['lost']:.2f} % of {found['scans']} scans; {_after('found', found['found_after'])}")
    if found["kidnapped"]:
        longest = _after(", the last", found["recovered_after"]) if found["recovered"] else ""
        out.print(f"kidnapped {counted(found['kidnapped'], 'time')}, recovered {found['recovered']}{longest}")
    if found["lost_at_end"]:
        out.print("[bold red]lost at the end[/]: does the map match the track?")


def _after(what: str, seconds: float | None) -> str:
    return f"{what} after {seconds:.2f} s" if seconds is not None else f"never {what}"
