"""Progress and results of `firstlap tune`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from firstlap.cli.common import console, progress_bar
from firstlap.common.text import counted, short_name

if TYPE_CHECKING:
    from firstlap.tuning.search import Budget


@contextmanager
def live_bar(budget: Budget) -> Iterator[Any]:
    """A progress bar on stderr: trials, best lap, share of reliable candidates, remaining time."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with progress_bar(*columns) as bar:
        yield _bar_watch(bar, budget)


def _bar_watch(bar: Progress, budget: Budget) -> Any:
    from firstlap.tuning.run import TuningProgress

    total = budget.trials or (budget.seconds or 0.0)

    class BarWatch(TuningProgress):
        """Shows the search on a bar, and below it the later steps, whose length is unknown."""

        def __init__(self) -> None:
            self.search: TaskID = bar.add_task("racing the starting setups", total=total)
            self.later: dict[str, TaskID] = {}
            self.races_of: dict[str, int] = {}
            self.reliable = 0
            self.trials = 0

        def trial(self, search: Any, trial: Any) -> None:
            self.trials += 1
            self.reliable += trial.verdict.holds
            best = search.best
            done = search.seconds if budget.trials is None else len(search.study.trials)
            seconds = (total - done) * (1.0 if budget.trials is None else search.seconds / max(done, 1))
            lap = f"best {best.cost:.2f} s, " if best else ""
            share = f"{100 * self.reliable / self.trials:.0f} % reliable"
            text = f"trial {trial.number + 1}, {lap}{share}, {max(seconds, 0.0):.0f} s left"
            bar.update(self.search, completed=min(done, total), description=text)

        def races(self, what: str, count: int) -> None:
            if what not in self.later:
                self.later[what] = bar.add_task(what, total=None)
            self.races_of[what] = self.races_of.get(what, 0) + count
            bar.update(self.later[what], description=f"{what}: {self.races_of[what]} races")

    return BarWatch()


def print_tuned(found: dict[str, Any], page: Path) -> None:
    """Prints the result as a table."""
    start = found["compared_with"]
    table = Table(
        title=escape(f"{short_name(found['track'])}, {found['direction']}: {counted(found['trials'], 'trial')}")
    )
    table.caption = "on check seeds, half of the races at the worst limits of the spread"
    table.add_column("setup")
    for heading in ("lap s", f"less than {start['setup']}", "failed", "clearance m"):
        table.add_column(heading, justify="right", overflow="fold")
    safety = (f"{start['failed']} of {start['races']}", f"{start['clearance']:.2f}")
    table.add_row(start["setup"], f"{start['lap']:.2f}", "", *safety)
    marked = [(title, found[role]) for role, title in (("holds", "fastest reliable"), ("seen", "fastest seen"))]
    for title, entry in marked:
        if entry:
            lap = entry["lap"] or entry["lap_in_search"]
            less = "" if entry["less"] is None else f"{100 * entry['less']:.1f} %"
            failed = f"{entry['failed']} of {entry['races']}"
            table.add_row(title, f"{lap:.2f}", less, failed, f"{entry['clearance']:.2f}")
    out = console()
    out.print(table)
    out.print(
        escape(
            f"{found['laps']:.0f} laps simulated in {found['seconds']:.0f} s of search: "
            f"{found['laps_per_second']:.1f} per second with {found['workers']} workers"
        )
    )
    if found["validation"]:
        out.print(escape(found["validation"]["verdict"]))
    files = [f"{title} {entry['file']}" for title, entry in marked if entry]
    out.print(escape("; ".join([*files, f"report {page}", f"study {found['study']} in {found['study_file']}"])))
