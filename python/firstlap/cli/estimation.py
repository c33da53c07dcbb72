"""firstlap estimation"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LapsOption,
    SeedOption,
    SetOption,
    SetupOption,
    TracksArgument,
    check_outputs,
    chosen_car,
    chosen_setup,
    console,
    counting_bar,
    draw,
    fail,
    print_json,
)
from firstlap.cli.survey import expand
from firstlap.common.errors import InputError
from firstlap.common.text import counted
from firstlap.common.version import __version__
from firstlap.config.driver_kind import driver_kind
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.evaluation.estimation.cases import Case
    from firstlap.evaluation.estimation.drive import Drive

CaseOption = Annotated[
    str | None, typer.Option("--case", metavar="NAME", help="Only this case: clean, bias, slip, lock or all.")
]
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FILE", help="Plot the last race over time; needs --case."),
]


def estimation(
    tracks: TracksArgument,
    setup: SetupOption = None,
    changes: SetOption = None,
    laps: LapsOption = 2,
    seed: SeedOption = 1,
    car: CarOption = "default",
    case: CaseOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> int:
    """Race with the state estimate, and compare it and the measured values with the truth at every scan.

    The cases are described in docs/estimation.md. Exit code 0 if every race finished, 1 otherwise.
    """
    from firstlap.evaluation.estimation.drive import drive
    from firstlap.evaluation.estimation.plot import plot_drive

    cases = _cases(case)
    if plot is not None and case is None:
        raise InputError("--plot: needs --case, whose race it shows")
    check_outputs(plot)
    chosen, the_car = chosen_setup(setup, changes), chosen_car(car, None)
    if driver_kind(chosen.driver).needs_map:
        raise InputError(f"driver {chosen.driver}: needs a map; expected a driver without one")
    loaded = {spec: load_track(spec) for spec in expand(tracks)}
    rows, shown, interrupted = _drive(
        cases, list(loaded.values()), lambda track, one: drive(track, chosen, the_car, one, laps=laps, seed=seed)
    )
    if as_json:
        print_json({"version": __version__, "setup": chosen.name, "car": the_car.name, "tracks": list(loaded),
                    "laps": laps, "seed": seed, "interrupted": interrupted, "cases": rows})  # fmt: skip
    else:
        print_table(f"setup {chosen.name}, {counted(laps, 'lap')} of {', '.join(loaded)}", rows)
    if shown is not None:
        title = f"{list(loaded)[-1]}, setup {chosen.name}: {shown.case.description}"
        draw(plot, lambda path: plot_drive(shown, title, path), as_json)
    if interrupted:
        return fail(f"interrupted after {len(rows)} of {counted(len(cases), 'case')}", 130)
    return 0 if all(row["finished"] == row["races"] for row in rows) else 1


def _cases(name: str | None) -> list[Case]:
    """The case of this name, or all. Raises InputError."""
    from firstlap.evaluation.estimation.cases import CASES

    names = [one.name for one in CASES]
    if name is not None and name not in names:
        raise InputError(f"--case {name[:60]}: no such case; available: {', '.join(names)}")
    return [one for one in CASES if name in (None, one.name)]


def _drive(
    cases: list[Case], tracks: list[Track], race: Callable[[Track, Case], Drive]
) -> tuple[list[dict[str, Any]], Drive | None, bool]:
    """The errors in each finished case, the last race, and whether the races were interrupted."""
    from firstlap.evaluation.estimation.drive import errors

    rows: list[dict[str, Any]] = []
    last = None
    with counting_bar() as bar:
        task = bar.add_task("racing", total=len(cases) * len(tracks))
        try:
            for case in cases:
                drives = []
                for track in tracks:
                    drives.append(race(track, case))
                    bar.advance(task)
                rows.append(errors(drives))
                last = drives[-1]
        except KeyboardInterrupt:
            return rows, last, True
    return rows, last, False


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
