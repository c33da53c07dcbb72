"""firstlap paper"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LidarOption,
    ReverseOption,
    TrackArgument,
    chosen_car,
    console,
    note,
    print_json,
    progress_bar,
)
from firstlap.cli.compare import drive_with_progress as drive_comparison
from firstlap.cli.output_folder import output_folder
from firstlap.cli.tune_paper import drive_with_progress, print_settings
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.setup_file import load_setup
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.evaluation.compare.compare import Comparison
    from firstlap.paper.report import PaperRun

RECORDINGS = (".mcap", ".bag", ".db3", ".npz", ".zstd", ".zst", ".active")


def paper(
    track: TrackArgument,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Output folder of report and figures.")],
    seeds: Annotated[int, typer.Option("--seeds", min=1, max=1000, help="Races per setting and driver.")] = 3,
    drivers: Annotated[
        str | None,
        typer.Option(
            "--drivers", metavar="A,B:SETUP", help="Drivers of the comparison; default: all, and those tuned for TRACK."
        ),
    ] = None,
    reverse: ReverseOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, max=1024, help="Parallel races; default: all cores.")
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Drive everything that the paper reports, on any track, and write a report with its figures."""
    from firstlap.paper.comparison import compared_drivers, has_global, make_comparison
    from firstlap.paper.report import summary, write_paper_report

    if track.lower().endswith(RECORDINGS):
        raise InputError(f"{track}: is a recording, which cannot be raced; expected a track or a map (see `replay`)")
    loaded, loaded_car = load_track(track), chosen_car(car, lidar)
    if drivers is None and not has_global():
        note("without the map-based driver: its packages are not installed (make extras)")
    named = compared_drivers(loaded) if drivers is None else drivers
    raced = loaded.reversed() if reverse else loaded
    comparison = make_comparison(raced, loaded_car, named, seeds, workers)
    folder = output_folder(out)
    run = _drive(raced, loaded_car, reverse, (comparison, seeds, workers))
    with progress_bar(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()) as bar:
        task = bar.add_task("drawing", total=None)
        files = write_paper_report(run, folder, lambda: bar.advance(task))
    if as_json:
        print_json({**summary(run), "files": [str(path) for path in files]})
    else:
        _print(run, folder)
    return 0


def _drive(track: Track, car: Car, reverse: bool, how: tuple[Comparison, int, int | None]) -> PaperRun:
    """Races settings and drivers; how: the comparison, not driven, seeds, workers. Ctrl-C ends it."""
    from firstlap.evaluation.published import FIRST
    from firstlap.paper.report import SEED, PaperRun
    from firstlap.paper.scenes import drive_lap
    from firstlap.paper.settings import PaperPlan, paper_settings
    from firstlap.tuning.variation import SPREAD_NAMES, evaluation_values

    comparison, seeds, workers = how
    judge = evaluation_values(None)
    spread = {name: judge[name] for name in SPREAD_NAMES}
    driven, alone = (
        drive_with_progress(track, car, PaperPlan(paper_settings(published_only=only), spread, seeds, workers))
        for only in (False, True)
    )
    if drive_comparison(comparison):
        raise KeyboardInterrupt
    lap = drive_lap(track, load_setup(FIRST), car, SEED)
    return PaperRun(track, car, reverse, seeds, lap, driven, alone, comparison)


def _print(run: PaperRun, folder: Path) -> None:
    from firstlap.evaluation.compare.report import order_lines
    from firstlap.paper.report import summary
    from firstlap.paper.settings_report import HEADINGS, setting_rows

    found = summary(run)
    print_settings(f"the paper's settings on {run.name}", HEADINGS, setting_rows(found["settings"]))
    for line in order_lines(found["comparison"]):
        console().print(escape(line))
    console().print(escape(f"report: {folder / 'report.html'}"), soft_wrap=True)
