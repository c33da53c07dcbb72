"""firstlap compare"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    ConditionOption,
    JsonOption,
    LapsOption,
    LatencyOption,
    LidarOption,
    ReverseOption,
    TrackArgument,
    check_outputs,
    chosen_car,
    chosen_options,
    console,
    counting_bar,
    described_options,
    draw,
    fail,
    note,
    print_json,
)
from firstlap.common.files import check_writable
from firstlap.common.text import counted, short_name
from firstlap.common.version import __version__
from firstlap.sim.race import latency_options
from firstlap.tracks.library import load_track

PIPE_WIDTH = 180
"""Columns of the table where it is not written to a terminal."""
WORDS_WIDTH = 14
"""Least columns of the text that wraps."""

DriversOption = Annotated[
    str | None,
    typer.Option(
        "--drivers",
        metavar="A,B:SETUP",
        help="Drivers, each with an optional setup; default: all, local also with brisk and race.",
    ),
]
SeedsOption = Annotated[int, typer.Option("--seeds", min=1, max=10_000, help="Races per driver, seeds 1 to K.")]
JobsOption = Annotated[int | None, typer.Option("--jobs", min=1, max=1024, help="Parallel races; default: all cores.")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot lines, laps and speeds.")]
ReportOption = Annotated[
    Path | None,
    typer.Option(
        "--report",
        metavar="FILE",
        help="Write a report (.md or .html) with everything needed to reproduce the result.",
    ),
]
StoreOption = Annotated[
    Path | None, typer.Option("--store", metavar="FOLDER", help="Folder that caches races for later runs.")
]


def compare(
    track: TrackArgument,
    drivers: DriversOption = None,
    laps: LapsOption = 10,
    seeds: SeedsOption = 5,
    reverse: ReverseOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    latency: LatencyOption = "measured",
    conditions: ConditionOption = None,
    jobs: JobsOption = None,
    plot: PlotOption = None,
    report: ReportOption = None,
    store: StoreOption = None,
    as_json: JsonOption = False,
) -> int:
    """Compare drivers on a track: lap time, success, clearance, compute time. Exit code 0 if every race finished."""
    from firstlap.common.cache import cache_folder
    from firstlap.evaluation.compare.compare import Comparison, parse_entries
    from firstlap.evaluation.compare.record import Store

    latency_options(latency)
    loaded_car = chosen_car(car, lidar)
    options = chosen_options(conditions, loaded_car)
    _check_files(plot, report)
    entries = parse_entries(drivers, loaded_car)
    loaded = load_track(track)
    comparison = Comparison(
        loaded.reversed() if reverse else loaded,
        entries,
        loaded_car,
        laps=laps,
        seeds=seeds,
        latency=latency,
        store=Store(store or cache_folder("compare")),
        options=options,
        jobs=jobs,
    )
    interrupted = drive_with_progress(comparison)
    found = {
        "version": __version__,
        "direction": "reverse" if reverse else "forward",
        **comparison.to_dict(),
        "interrupted": interrupted,
    }
    command = _command(locals())
    if as_json:
        print_json(found)
    else:
        _print(found, comparison.track.notes)
    if not interrupted:
        _write_files(comparison, plot, report, command, as_json)
    driven = sum(row["runs"] for row in found["entries"])
    if interrupted:
        return fail(f"interrupted after {driven} of {comparison.races} races; the same command resumes there", 130)
    return 0 if all(row["success_rate"] == 1.0 for row in found["entries"]) else 1


def _check_files(plot: Path | None, report: Path | None) -> None:
    """Raises InputError before the races if an output file cannot be written."""
    from firstlap.evaluation.compare.report import REPORTS

    check_outputs(plot)
    if report:
        check_writable(report, REPORTS)


def drive_with_progress(comparison: Any) -> bool:
    """Runs the races with a progress bar; returns whether they were interrupted."""
    failed = 0
    with counting_bar() as bar:
        task = bar.add_task("racing", total=comparison.races)
        preparation: dict[str, Any] = {}

        def done(_entry: Any, record: Any) -> None:
            nonlocal failed
            failed += not record.finished
            kept = f", {comparison.from_store} from the cache" if comparison.from_store else ""
            bar.update(task, advance=1, description=f"racing, {failed} not finished{kept}")

        def preparing(entry: Any, what: str, share: float) -> None:
            if entry.label not in preparation:
                preparation[entry.label] = bar.add_task(entry.label, total=100)
            bar.update(preparation[entry.label], description=f"{entry.label}: {what}", completed=100.0 * share)

        try:
            comparison.drive(done, preparing)
        except KeyboardInterrupt:
            return True
    return False


def _write_files(comparison: Any, plot: Path | None, report: Path | None, command: str, as_json: bool) -> None:
    if plot:
        from firstlap.evaluation.compare.plot import plot_comparison

        draw(plot, lambda path: plot_comparison(comparison, path), as_json)
    if report:
        from firstlap.evaluation.compare.report import write_report

        write_report(comparison, report, command)
        if not as_json:
            console().print(escape(f"report: {report}"), soft_wrap=True)


def _command(given: dict[str, Any]) -> str:
    """The command line that reproduces this comparison."""
    words = ["firstlap", "compare", given["track"]]
    words += ["--drivers", ",".join(entry.label for entry in given["entries"])]
    for name in ("laps", "seeds", "car", "lidar", "latency", "plot", "report"):
        if given[name] is not None:
            words += [f"--{name}", str(given[name])]
    for assignment in given["conditions"] or ():
        words += ["--option", assignment]
    if given["reverse"]:
        words.append("--reverse")
    return shlex.join(words)


def _print(found: dict[str, Any], notes: list[str]) -> None:
    from firstlap.evaluation.compare.report import HEADINGS, order_lines, table_rows

    for remark in notes:
        note(remark)
    title = (
        f"{short_name(found['track'])}, {found['track_length']:.1f} m, {counted(found['laps'], 'lap')}, "
        f"{counted(found['seeds'], 'seed')}, latency "
    )
    table = Table(title=escape(title + found["latency"] + described_options(found["options"])))
    for heading in HEADINGS:
        words = heading == "tuned for"
        table.add_column(
            heading,
            justify="left" if heading in HEADINGS[:2] else "right",
            no_wrap=not words,
            min_width=WORDS_WIDTH if words else None,
        )
    for row, cells in zip(found["entries"], table_rows(found), strict=True):
        style = "" if row["finished"] == row["runs"] else "red" if row["finished"] == 0 else "yellow"
        table.add_row(*map(escape, cells), style=style)
    out = console()
    if not out.is_terminal:
        out.width = PIPE_WIDTH
    out.print(table)
    if found["reference"]:
        out.print(escape(f"relative: median lap time divided by that of {found['reference']}"))
    for line in order_lines(found):
        out.print(escape(line))
