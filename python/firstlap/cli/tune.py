"""firstlap tune"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from firstlap.cli.common import (
    CarOption,
    DriverOption,
    JsonOption,
    LidarOption,
    TrackArgument,
    chosen_car,
    fail,
    note,
    print_json,
)
from firstlap.cli.output_folder import output_folder
from firstlap.cli.tune_paper import paper_plan, refuse_unused, run_paper
from firstlap.cli.tune_tables import live_bar, print_tuned
from firstlap.common.errors import InputError
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.tuning.run import Tuned
    from firstlap.tuning.search import Budget
    from firstlap.tuning.validate import Validation

StartOption = Annotated[
    str | None,
    typer.Option(
        "--from", metavar="SETUP", help="Setup to start from and to beat; default: base, or the driver's own."
    ),
]
OthersOption = Annotated[
    str | None,
    typer.Option(
        "--starts",
        metavar="SETUP,...",
        help="Further starting setups, or none; default: all our setups of the driver.",
    ),
]
BudgetOption = Annotated[
    str,
    typer.Option(
        "--budget",
        metavar="TIME|N",
        help="Time for search and selection (3m, 90s, 1h), or a number of trials.",
    ),
]
SeedsOption = Annotated[int, typer.Option("--seeds", min=1, max=1000, help="Races per candidate.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of all randomness in the search.")]
OnlyOption = Annotated[str | None, typer.Option("--only", metavar="NAME,...", help="Tune only these parameters.")]
FixOption = Annotated[str | None, typer.Option("--fix", metavar="NAME,...", help="Keep these parameters fixed.")]
JudgingOption = Annotated[
    list[str] | None,
    typer.Option(
        "--judge",
        metavar="NAME=VALUE",
        help="How candidates are evaluated, such as friction=0.2; names: docs/parameters.md.",
    ),
]
ReverseOption = Annotated[bool, typer.Option("--reverse", help="Tune for the opposite direction.")]
NameOption = Annotated[
    str | None, typer.Option("--name", metavar="NAME", help="Name of the study; an existing one is resumed.")
]
StudyFileOption = Annotated[
    Path, typer.Option("--study", metavar="FILE", help="Database of all studies, for optuna-dashboard.")
]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="FOLDER", help="Output folder for setups and report; default: tuned/NAME."),
]
AlsoOption = Annotated[
    list[str] | None, typer.Option("--also", metavar="TRACK", help="Also validate on this track; repeatable.")
]
ValidatedOption = Annotated[
    bool, typer.Option("--validate/--no-validate", help="Race the result on unseen seeds and on other tracks.")
]
ClusterOption = Annotated[
    str | None,
    typer.Option("--cluster", metavar="ADDRESS", help="Dask scheduler for the races; default: this machine."),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", min=1, max=1024, help="Parallel races on this machine; default: all cores."),
]
PopulationOption = Annotated[
    int | None,
    typer.Option(
        "--population",
        min=4,
        max=10_000,
        help="Candidates per generation; default: depends on the number of parameters.",
    ),
]
PaperOption = Annotated[bool, typer.Option("--paper", help="No search: drive the paper's settings on TRACK.")]
PublishedOnlyOption = Annotated[
    bool, typer.Option("--published-only", help="With --paper: change nothing but what the paper prints.")
]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="With --paper: change a parameter in all settings."),
]


def tune(
    context: typer.Context,
    track: TrackArgument,
    start: StartOption = None,
    others: OthersOption = None,
    driver: DriverOption = None,
    budget: BudgetOption = "3m",
    seeds: SeedsOption = 8,
    seed: SeedOption = 1,
    only: OnlyOption = None,
    fix: FixOption = None,
    judging: JudgingOption = None,
    reverse: ReverseOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    name: NameOption = None,
    study_file: StudyFileOption = Path("firstlap-tuning.db"),
    out: OutOption = None,
    also: AlsoOption = None,
    validated: ValidatedOption = True,
    cluster: ClusterOption = None,
    workers: WorkersOption = None,
    population: PopulationOption = None,
    paper: PaperOption = False,
    published_only: PublishedOnlyOption = False,
    changes: ChangesOption = None,
    as_json: JsonOption = False,
) -> int:
    """Search for the fastest reliable setup on a track. Exit code 0 if one was found, 1 otherwise."""
    from firstlap.tuning.search import parse_budget
    from firstlap.tuning.session import check_name, make_session, new_name
    from firstlap.tuning.study import check_study_file, quiet_optuna
    from firstlap.tuning.variation import evaluation_values

    refuse_unused(context, paper)
    if paper:
        plan = paper_plan(start, published_only, changes, judging, (seeds, workers))
        return run_paper(track, reverse, chosen_car(car, lidar), plan, (out, as_json))
    quiet_optuna()
    limit = parse_budget(budget)
    judge = evaluation_values(judging)
    check_study_file(study_file)
    session = make_session(
        track,
        load_track(track),
        driver=driver,
        start=start,
        others=others,
        car=chosen_car(car, lidar),
        judge=judge,
        seeds=seeds,
        seed=seed,
        reverse=reverse,
        only=only,
        fix=fix,
        population=population,
    )
    known = {spec: load_track(spec) for spec in also or []}
    elsewhere = None if not validated else ([] if judge["other_seeds"] < 1 else list_tracks(), known, track)
    name = check_name(name) if name is not None else new_name(study_file, session.track, session.driver, reverse)
    folder = output_folder(out or Path("tuned") / name)
    tuned, validation = _run(session, name, study_file, limit, (cluster, workers), elsewhere)
    return _finish(tuned, validation, folder, study_file, as_json)


def _run(
    session: Any,
    name: str,
    study_file: Path,
    budget: Budget,
    where: tuple[str | None, int | None],
    others: tuple[list[str], dict[str, Track], str] | None,
) -> tuple[Tuned, Validation | None]:
    """Runs search, selection and validation. Raises InputError, also if the connection to the cluster is lost."""
    from firstlap.tuning.run import tune as run_tuning
    from firstlap.tuning.run import validate_tuned
    from firstlap.tuning.study import only_one, open_study

    with only_one(study_file, name):
        study = open_study(study_file, name, session.about())
        if study.trials:
            note(f"study {name}: resuming after {len(study.trials)} trials, {study.seconds:.0f} s of search")
        with _resume_hint(name, study_file, study), _pool(session.driver, *where) as pool, live_bar(budget) as watch:
            tuned = run_tuning(session, study, pool, budget, watch)
            return tuned, validate_tuned(tuned, _other_tracks(*others), pool, watch) if others is not None else None


def _other_tracks(ours: list[str], also: dict[str, Track], tuned_for: str) -> dict[str, Track]:
    """All tracks of the validation except the tuned one; ours are loaded only now, when they are needed."""
    return {name: load_track(name) for name in ours if name != tuned_for} | also


@contextmanager
def _resume_hint(name: str, path: Path, study: Any) -> Iterator[None]:
    """Prints what is saved if the search ends early."""
    from firstlap.tuning.pool import PoolGoneError

    try:
        yield
    except PoolGoneError as error:
        raise InputError(f"{error}; {_resume(name, path, study)}") from None
    except KeyboardInterrupt:
        note(_resume(name, path, study))
        raise


def _resume(name: str, path: Path, study: Any) -> str:
    return f"{len(study.trials)} finished trials are saved in {path}; the same command with --name {name} resumes"


@contextmanager
def _pool(driver: str, cluster: str | None, workers: int | None) -> Iterator[Any]:
    from firstlap.tuning.pool import make_pool

    pool = make_pool(driver, cluster, workers)
    try:
        yield pool
    finally:
        pool.close()


def _finish(tuned: Tuned, validation: Validation | None, folder: Path, study_file: Path, as_json: bool) -> int:
    from firstlap.tuning.report import report
    from firstlap.tuning.run import write_setups
    from firstlap.tuning.setup_writer import write_text
    from firstlap.tuning.summary import summary

    files = write_setups(tuned, folder)
    found = summary(tuned, files, study_file, validation)
    page = folder / "report.html"
    command = "firstlap " + shlex.join(sys.argv[1:])
    write_text(page, report(tuned, found, validation, command))
    if as_json:
        print_json({**found, "report": str(page)})
    else:
        print_tuned(found, page)
    if tuned.choice.holds is None:
        return fail("no reliable setup on the check seeds; try a longer --budget or a smaller --judge margin", 1)
    return 0
