"""firstlap tune --paper"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.table import Table

from firstlap.cli.common import console, print_json, progress_bar
from firstlap.cli.output_folder import output_folder
from firstlap.common.errors import InputError
from firstlap.common.text import short_name
from firstlap.config.car_file import Car
from firstlap.config.setup_file import load_setup
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.paper.settings import PaperPlan, SettingResult

OF_THE_PAPER = {"published_only": "--published-only", "changes": "--set"}
"""Parameters of the command that need --paper, and their options."""
WITH_PAPER = {*OF_THE_PAPER, "track", "start", "seeds", "judging", "reverse", "car", "lidar", "out", "workers", "paper",
              "as_json"}  # fmt: skip
"""Parameters of the command that have an effect with --paper."""


def refuse_unused(context: typer.Context, paper: bool) -> None:
    """Raises InputError for the first option on the command line that has no effect with --paper, or without it."""
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if source is None or source.name != "COMMANDLINE":
            continue
        if paper and name not in WITH_PAPER:
            raise InputError(f"{parameter.opts[0]}: has no effect with --paper")
        if not paper and name in OF_THE_PAPER:
            raise InputError(f"{OF_THE_PAPER[name]}: has no effect without --paper; --from FILE sets the start")


def paper_plan(
    start: str | None,
    published_only: bool,
    changes: list[str] | None,
    judging: list[str] | None,
    how: tuple[int, int | None],
) -> PaperPlan:
    """What is driven; judging: as of --judge, the spread alone; how: seeds and workers. Raises InputError."""
    from firstlap.paper.settings import PaperPlan, paper_settings
    from firstlap.tuning.variation import SPREAD_NAMES, evaluation_values

    judge = evaluation_values(judging)
    for text in judging or ():
        name = text.partition("=")[0].strip().rpartition(".")[2]
        if name not in SPREAD_NAMES:
            raise InputError(f"--judge {name}: has no effect with --paper; expected one of {', '.join(SPREAD_NAMES)}")
    settings = paper_settings(
        None if start is None else load_setup(start), published_only=published_only, changes=changes or ()
    )
    return PaperPlan(settings, {name: judge[name] for name in SPREAD_NAMES}, *how)


def drive_with_progress(track: Track, car: Car, plan: PaperPlan) -> list[SettingResult]:
    """Races the settings; Ctrl-C ends all races."""
    from firstlap.paper.settings import drive_paper
    from firstlap.tuning.pool import StoppedError

    stop = threading.Event()

    def look(_running: object) -> None:
        if stop.is_set():
            raise StoppedError

    with progress_bar(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()) as bar:
        task = bar.add_task("racing the paper's settings", total=plan.races)
        try:
            return drive_paper(track, car, plan, lambda: bar.advance(task), look)
        except KeyboardInterrupt:
            stop.set()
            raise


def run_paper(spec: str, reverse: bool, car: Car, plan: PaperPlan, output: tuple[Path | None, bool]) -> int:
    """Drives the settings and writes the report; output: folder and whether to print JSON."""
    from firstlap.paper.settings import paper_summary
    from firstlap.paper.settings_report import settings_page
    from firstlap.tuning.setup_writer import write_text

    loaded = load_track(spec)
    track = loaded.reversed() if reverse else loaded
    out, as_json = output
    folder = output_folder(out or Path("tuned") / f"paper-{Path(loaded.name).stem}")
    driven = drive_with_progress(track, car, plan)
    found = paper_summary(spec, track, car, driven)
    page = folder / "report.html"
    write_text(page, settings_page(found, driven))
    if as_json:
        print_json({**found, "report": str(page)})
    else:
        _print(found, page)
    return 0


def _print(found: dict[str, Any], page: Path) -> None:
    from firstlap.paper.settings import silent_sentences
    from firstlap.paper.settings_report import HEADINGS, setting_rows

    print_settings(f"the paper's settings on {short_name(found['track'])}", HEADINGS, setting_rows(found))
    out = console()
    out.print(escape(f"not printed in the paper: {'; '.join(silent_sentences(found))}"))
    out.print(escape(f"report {page}"), soft_wrap=True)


def print_settings(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints the settings beside the paper's lap times."""
    table = Table(title=escape(title))
    for heading in headings:
        table.add_column(escape(heading), justify="right")
    for row in rows:
        table.add_row(*map(escape, row))
    console().print(table)
