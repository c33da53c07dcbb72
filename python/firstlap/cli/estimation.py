"""firstlap estimation"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LapsOption,
    SeedOption,
    SetOption,
    SetupOption,
    TracksArgument,
    chosen_car,
    chosen_setup,
    console,
    draw,
    print_json,
    progress_bar,
)
from firstlap.cli.survey import expand
from firstlap.common.errors import InputError
from firstlap.common.files import check_writable
from firstlap.common.text import counted
from firstlap.common.version import __version__
from firstlap.config.driver_kind import driver_kind
from firstlap.tracks.library import load_track


def estimation(
    tracks: TracksArgument,
    setup: SetupOption = None,
    changes: SetOption = None,
    laps: LapsOption = 2,
    seed: SeedOption = 1,
    car: CarOption = "default",
    case: Annotated[
        str | None, typer.Option("--case", metavar="NAME", help="Only this case: clean, bias, slip, lock or all.")
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Plot the last race over time; needs --case."),
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Race with the state estimate, and compare it and the measured values with the truth at every scan.

    The cases are described in docs/estimation.md. Exit code 0 if every race finished, 1 otherwise.
    """
    from firstlap.evaluation.estimation.cases import CASES
    from firstlap.evaluation.estimation.drive import drive, errors
    from firstlap.evaluation.estimation.plot import plot_drive
    from firstlap.plots.primitives import PICTURE_SUFFIXES

    names = [one.name for one in CASES]
    if case is not None and case not in names:
        raise InputError(f"--case {case[:60]}: no such case; available: {', '.join(names)}")
    if plot is not None:
        if case is None:
            raise InputError("--plot: needs --case, whose race it shows")
        check_writable(plot, PICTURE_SUFFIXES)
    chosen, the_car = chosen_setup(setup, changes), chosen_car(car, None)
    if driver_kind(chosen.driver).needs_map:
        raise InputError(f"driver {chosen.driver}: needs a map; expected a driver without one")
    cases = [one for one in CASES if case in (None, one.name)]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    rows, shown = [], None
    with progress_bar(*columns) as bar:
        loaded = {spec: load_track(spec) for spec in expand(tracks)}
        task = bar.add_task("racing", total=len(cases) * len(loaded))
        for one in cases:
            drives = []
            for track in loaded.values():
                drives.append(drive(track, chosen, the_car, one, laps=laps, seed=seed))
                bar.advance(task)
            rows.append(errors(drives))
            shown = drives[-1]
    if as_json:
        print_json({"version": __version__, "setup": chosen.name, "car": the_car.name, "tracks": list(loaded),
                    "laps": laps, "seed": seed, "cases": rows})  # fmt: skip
    else:
        print_table(f"setup {chosen.name}, {counted(laps, 'lap')} of {', '.join(loaded)}", rows)
    if shown is not None:
        title = f"{list(loaded)[-1]}, setup {chosen.name}: {shown.case.description}"
        draw(plot, lambda path: plot_drive(shown, title, path), as_json)
    return 0 if all(row["finished"] == row["races"] for row in rows) else 1


def print_table(title: str, rows: list[dict[str, Any]]) -> None:
    """Prints one row per case, as in docs/estimation.md."""
    table = Table(title=escape(title), caption="RMS errors: measured → estimated; speeds in m/s, yaw rate in rad/s")
    for heading in ("case", "speed", "locked", "no\naccel.", "yaw rate", "gyro\nbias", "side slip"):
        table.add_column(heading, justify="left" if heading == "case" else "right")
    for row in rows:
        table.add_row(
            row["case"],
            _pair(row["speed"]),
            _pair(row["locked"], 2),
            _number(row["speed"]["without_accelerometer"]),
            _pair(row["yaw_rate"]),
            _number(row["yaw_rate_bias"]["error"]),
            _pair(row["lateral_speed"], 2),
        )
    console().print(table)
    for row in rows:
        if row["finished"] < row["races"]:
            console().print(f"{row['case']}: {row['finished']} of {row['races']} races finished")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def _pair(found: dict[str, Any], digits: int = 3) -> str:
    return "-" if found["raw"] is None else f"{found['raw']:.{digits}f}→{found['estimate']:.{digits}f}"
