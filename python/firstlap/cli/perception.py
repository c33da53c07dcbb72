"""firstlap perception"""

from __future__ import annotations

from typing import Any

from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    BothOption,
    CarOption,
    JsonOption,
    LapsOption,
    LidarOption,
    SeedOption,
    SetOption,
    SetupOption,
    TracksArgument,
    chosen_car,
    chosen_setup,
    console,
    counting_bar,
    fail,
    print_json,
)
from firstlap.cli.survey import expand
from firstlap.common.text import counted, short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.evaluation.survey import Run
from firstlap.tracks.library import load_track


def perception(
    tracks: TracksArgument,
    setup: SetupOption = None,
    changes: SetOption = None,
    laps: LapsOption = 1,
    seed: SeedOption = 1,
    both: BothOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    as_json: JsonOption = False,
) -> int:
    """Race tracks and compare the perceived walls and centerline with ground truth in every scan.

    The metrics are defined in docs/perception.md. Exit code 0 if every race finished, 1 otherwise.
    """
    chosen, the_car = chosen_setup(setup, changes), chosen_car(car, lidar)
    loaded = {spec: load_track(spec) for spec in expand(tracks)}
    directions = (False, True) if both else (False,)
    runs = [Run(spec, track, reverse, seed) for spec, track in loaded.items() for reverse in directions]
    rows, interrupted = _measure(runs, chosen, the_car, laps)
    found = {
        "version": __version__,
        "setup": chosen.name,
        "set": {f"{section}.{name}": value for (section, name), value in chosen.changed.items()},
        "car": the_car.name,
        "laps": laps,
        "interrupted": interrupted,
        "runs": rows,
    }
    if as_json:
        print_json(found)
    else:
        print_table(f"setup {chosen.name}, {counted(laps, 'lap')}", rows)
    if interrupted:
        return fail(f"interrupted after {len(rows)} of {len(runs)} races", 130)
    return 0 if all(row["outcome"] == "finished" for row in rows) else 1


def _measure(runs: list[Run], setup: Setup, car: Car, laps: int) -> tuple[list[dict[str, Any]], bool]:
    """One row per race, and whether the measurement was interrupted."""
    from firstlap.evaluation.perception.survey import survey_perception

    rows: list[dict[str, Any]] = []
    with counting_bar() as bar:
        task = bar.add_task("measuring", total=len(runs))

        def done(_run: Run, row: dict[str, Any]) -> None:
            rows.append(row)
            bar.advance(task)

        try:
            return survey_perception(runs, setup, car, laps=laps, done=done), False
        except KeyboardInterrupt:
            return rows, True


def print_table(title: str, rows: list[dict[str, Any]]) -> None:
    """Prints one row per run with the metrics of docs/perception.md."""
    table = Table(
        title=escape(title), caption="mm, median / 95th percentile of the error at that distance ahead; shares in %"
    )
    table.add_column("track", overflow="fold")
    for heading in ("1 m", "2 m", "3 m", "no line", "bad", "prec.", "recall", "jump"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        name = short_name(row["track"])
        name += " ↺" if row.get("direction") == "reverse" else ""
        errors = [_pair(row["error"][ahead]) for ahead in ("1", "2", "3")]
        shares = [_percent(row[key]) for key in ("no_line", "bad", "precision", "recall")]
        jump = row["jump"]["p95"]
        table.add_row(escape(name), *errors, *shares, "-" if jump is None else f"{1000 * jump:.0f}")
    console().print(table)


def _pair(error: dict[str, Any]) -> str:
    return "-" if error["median"] is None else f"{1000 * error['median']:.0f}/{1000 * error['p95']:.0f}"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f}"
