"""firstlap survey"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from firstlap.cli.common import (
    BothOption,
    CarOption,
    ConditionOption,
    DriverOption,
    JsonOption,
    LapsOption,
    LidarOption,
    SetOption,
    SetupOption,
    TracksArgument,
    chosen_car,
    chosen_options,
    chosen_setup,
    console,
    counting_bar,
    described_options,
    fail,
    print_json,
)
from firstlap.common.errors import InputError
from firstlap.common.text import counted, short_names
from firstlap.common.version import __version__
from firstlap.evaluation.survey import Run, Survey
from firstlap.sim.race import RaceResult
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

SeedsOption = Annotated[int, typer.Option("--seeds", min=1, max=10_000, help="Races per track, seeds 1 to K.")]


def survey(
    tracks: TracksArgument,
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    laps: LapsOption = 3,
    seeds: SeedsOption = 3,
    both: BothOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    options: ConditionOption = None,
    as_json: JsonOption = False,
) -> int:
    """Race many tracks, directions and seeds on all cores. Exit code 0 if every race finished, 1 otherwise."""
    the_car = chosen_car(car, lidar)
    races = Survey(chosen_setup(setup, changes, driver), the_car, laps, chosen_options(options, the_car))
    with counting_bar() as bar:
        loaded = _read(bar, expand(tracks))
        directions = (False, True) if both else (False,)
        runs = [
            Run(spec, track, reverse, seed)
            for spec, track in loaded.items()
            for reverse in directions
            for seed in range(1, seeds + 1)
        ]
        interrupted = _drive(bar, races, runs)
    found = {
        "version": __version__,
        **races.to_dict(),
        "seeds": seeds,
        "both": both,
        "interrupted": interrupted,
    }
    if as_json:
        print_json(found)
    else:
        _print(found)
    if interrupted:
        return fail(f"interrupted after {found['runs']} of {len(runs)} races", 130)
    return 0 if found["finished"] == len(runs) else 1


def _read(bar: Progress, specs: list[str]) -> dict[str, Track]:
    """The tracks by name. Raises InputError."""
    task, loaded = bar.add_task("reading tracks", total=len(specs)), {}
    for spec in specs:
        loaded[spec] = load_track(spec)
        bar.advance(task)
    bar.remove_task(task)
    return loaded


def _drive(bar: Progress, races: Survey, runs: list[Run]) -> bool:
    """Drives the races; returns whether they were interrupted."""
    failed = 0
    task = bar.add_task("racing", total=len(runs))

    def done(_run: Run, result: RaceResult) -> None:
        nonlocal failed
        failed += not result.finished
        bar.update(task, advance=1, description=f"racing, {failed} not finished")

    try:
        races.drive(runs, done)
    except KeyboardInterrupt:
        return True
    return False


def expand(tracks: list[str]) -> list[str]:
    """Expands "all" and "random:1-20" and removes duplicates. Raises InputError."""
    specs: list[str] = []
    for track in tracks:
        first, dash, last = track.removeprefix("random:").partition("-")
        if track == "all":
            specs += list_tracks()
        elif track.startswith("random:") and dash:
            if not (first.isdecimal() and last.isdecimal() and int(first) <= int(last) < int(first) + 10_000):
                raise InputError(f"'{track[:60]}': expected random:FIRST-LAST, for example random:1-20")
            specs += [f"random:{seed}" for seed in range(int(first), int(last) + 1)]
        else:
            specs.append(track)
    return list(dict.fromkeys(specs))


def _print(found: dict[str, Any]) -> None:
    both = ", both directions" if found["both"] else ""
    car = "" if found["car"] == "default" else f", car {found['car']}"
    conditions = car + described_options(found["options"])
    what = f"driver {found['driver']}, setup {found['setup']}"
    table = Table(
        title=escape(f"{what}, {counted(found['laps'], 'lap')}, {counted(found['seeds'], 'seed')}{both}{conditions}")
    )
    table.add_column("track", overflow="fold", min_width=13)
    for heading in ("length m", "finished", "best s", "median s", "clearance m"):
        table.add_column(heading, justify="right")
    table.add_column("first failure", overflow="fold")
    names = short_names([row["track"] for row in found["tracks"]])
    for row in found["tracks"]:
        style = "" if row["finished"] == row["runs"] else "red" if row["finished"] == 0 else "yellow"
        table.add_row(
            escape(names[row["track"]]),
            f"{row['track_length']:.1f}",
            f"{row['finished']}/{row['runs']}",
            _number(row["best"]),
            _number(row["median"]),
            _number(row["min_clearance"]),
            _failure(row["failures"]),
            style=style,
        )
    out = console()
    out.print(table)
    out.print(f"{found['finished']} of {counted(found['runs'], 'race')} finished")


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f}"


def _failure(failures: list[dict[str, Any]]) -> str:
    if not failures:
        return ""
    first = failures[0]
    return f"{first['outcome']} at {first['s']:.1f} m, {first['direction']}, seed {first['seed']}"
