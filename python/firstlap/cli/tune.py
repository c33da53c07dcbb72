"""firstlap tune"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from firstlap.car_file import load_car
from firstlap.cli.common import (
    CarOption,
    DriverOption,
    JsonOption,
    TrackArgument,
    console,
    fail,
    note,
    print_json,
    progress_bar,
)
from firstlap.errors import InputError
from firstlap.tracks.library import load_track

if TYPE_CHECKING:
    from firstlap.tuning.run import Tuned
    from firstlap.tuning.search import Budget


def tune(
    track: TrackArgument,
    start: Annotated[
        str | None,
        typer.Option("--from", metavar="SETUP", help="What to begin with and to beat; default: base or the driver's."),
    ] = None,
    driver: DriverOption = None,
    budget: Annotated[
        str, typer.Option("--budget", metavar="TIME|N", help="3m, 90s, 1h, or a number of trials.")
    ] = "3m",
    seeds: Annotated[int, typer.Option("--seeds", min=1, max=1000, help="Races of each candidate.")] = 8,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of everything random in the search.")] = 1,
    only: Annotated[
        str | None, typer.Option("--only", metavar="NAME,...", help="Change these parameters and no others.")
    ] = None,
    fix: Annotated[str | None, typer.Option("--fix", metavar="NAME,...", help="Leave these parameters alone.")] = None,
    judging: Annotated[
        list[str] | None,
        typer.Option("--judge", metavar="NAME=VALUE", help="How candidates are judged, such as friction=0.2."),
    ] = None,
    reverse: Annotated[bool, typer.Option("--reverse", help="Tune for the other way round.")] = False,
    car: CarOption = "default",
    name: Annotated[
        str | None, typer.Option("--name", metavar="NAME", help="Of the study; one that is there is resumed.")
    ] = None,
    study_file: Annotated[
        Path, typer.Option("--study", metavar="FILE", help="All studies; optuna-dashboard opens it.")
    ] = Path("firstlap-tuning.db"),
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="For setups and report; default: tuned/NAME.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="Of a Dask scheduler; default: this machine.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, max=1024, help="On this machine; default: its cores.")
    ] = None,
    population: Annotated[
        int | None, typer.Option("--population", min=4, max=10_000, help="Candidates of a generation.")
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Search for the fastest setup that holds on a track. Exits 0 when one was found, 1 when not."""
    from firstlap.tuning.run import tune as run_tuning
    from firstlap.tuning.search import parse_budget
    from firstlap.tuning.session import check_name, make_session, new_name
    from firstlap.tuning.spread import judge_values
    from firstlap.tuning.study import check_study_file, only_one, open_study, quiet_optuna

    quiet_optuna()
    limit = parse_budget(budget)
    judge = judge_values(judging)
    check_study_file(study_file)
    session = make_session(
        track,
        load_track(track),
        driver=driver,
        start=start,
        car=load_car(car),
        judge=judge,
        seeds=seeds,
        seed=seed,
        reverse=reverse,
        only=only,
        fix=fix,
        population=population,
    )
    name = check_name(name) if name is not None else new_name(study_file, session.track, session.driver, reverse)
    folder = _folder(out or Path("tuned") / name)
    with only_one(study_file, name):
        study = open_study(study_file, name, session.about())
        if study.trials:
            note(f"study {name}: {len(study.trials)} trials are there, {study.seconds:.0f} s of search")
        with _kept(name, study_file, study), _pool(session.driver, cluster, workers) as pool, _live(limit) as watch:
            tuned = run_tuning(session, study, pool, limit, watch)
    return _finish(tuned, folder, study_file, as_json)


def _folder(path: Path) -> Path:
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"--out {path}: cannot be written ({error.strerror})") from None
    return path


@contextmanager
def _kept(name: str, path: Path, study: Any) -> Iterator[None]:
    """Says what is kept when the search ends before its time."""
    from firstlap.tuning.pool import PoolGoneError

    try:
        yield
    except PoolGoneError as error:
        raise InputError(f"{error}; {_resume(name, path, study)}") from None
    except KeyboardInterrupt:
        note(_resume(name, path, study))
        raise


def _resume(name: str, path: Path, study: Any) -> str:
    return f"{len(study.trials)} finished trials are kept in {path}; the same command with --name {name} resumes"


@contextmanager
def _pool(driver: str, cluster: str | None, workers: int | None) -> Iterator[Any]:
    from firstlap.tuning.pool import make_pool

    pool = make_pool(driver, cluster, workers)
    try:
        yield pool
    finally:
        pool.close()


@contextmanager
def _live(budget: Budget) -> Iterator[Any]:
    """A bar on stderr: trials, best lap, share that holds, time left."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with progress_bar(*columns) as bar:
        yield _bar_watch(bar, budget)


def _bar_watch(bar: Progress, budget: Budget) -> Any:
    from firstlap.tuning.run import SEARCH_SHARE, Watch

    total = budget.trials or (budget.seconds or 0.0) * SEARCH_SHARE

    class BarWatch(Watch):
        """Shows it on a bar."""

        task: TaskID = bar.add_task("racing the starts", total=total)
        later: TaskID | None = None
        held = 0
        seen = 0

        def trial(self, search: Any, trial: Any) -> None:
            self.seen += 1
            self.held += trial.verdict.holds
            best = search.best
            done = search.seconds if budget.trials is None else len(search.study.trials)
            seconds = (total - done) * (1.0 if budget.trials is None else search.seconds / max(done, 1))
            text = (
                f"trial {trial.number + 1}, best {best.cost:.2f} s, " if best else f"trial {trial.number + 1}, "
            ) + f"{100 * self.held / self.seen:.0f} % hold, {max(seconds, 0.0):.0f} s left"
            bar.update(self.task, completed=min(done, total), description=text)

        def races(self, what: str, count: int) -> None:
            if self.later is None:
                self.later = bar.add_task(what, total=None)
            bar.update(self.later, advance=count, description=what)

    return BarWatch()


def _finish(tuned: Tuned, folder: Path, study_file: Path, as_json: bool) -> int:
    from firstlap.tuning.run import write_setups
    from firstlap.tuning.summary import summary

    files = write_setups(tuned, folder)
    found = summary(tuned, files, study_file)
    if as_json:
        print_json(found)
    else:
        _print(found)
    if tuned.choice.holds is None:
        return fail("no setup holds on fresh seeds; a longer --budget or a smaller --judge margin may find one", 1)
    return 0


def _print(found: dict[str, Any]) -> None:
    start = found["compared_with"]
    table = Table(title=escape(f"{found['track']}, {found['direction']}: {found['trials']} trials"))
    for heading in ("setup", "lap s", f"less than {start['setup']}", "failed", "clearance m", "file"):
        table.add_column(heading, justify="left" if heading in ("setup", "file") else "right", overflow="fold")
    table.add_row(start["setup"], f"{start['lap']:.2f}", "", "", "", "")
    for role, title in (("holds", "fastest that holds"), ("seen", "fastest seen")):
        if entry := found[role]:
            table.add_row(
                title,
                "-" if entry["lap"] is None else f"{entry['lap']:.2f}",
                "-" if entry["less"] is None else f"{100 * entry['less']:.1f} %",
                f"{entry['failed']} of {entry['races']}",
                f"{entry['clearance']:.2f}",
                escape(entry["file"]),
            )
    out = console()
    out.print(table)
    out.print(
        escape(f"{found['laps']:.0f} laps in {found['seconds']:.0f} s; study {found['study']} in {found['study_file']}")
    )
