"""firstlap ablation"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LidarOption,
    chosen_car,
    console,
    counting_bar,
    fail,
    note,
    print_json,
)
from firstlap.cli.survey import expand
from firstlap.common.errors import InputError
from firstlap.common.version import __version__
from firstlap.config.setup_file import DEFAULT_SETUP, LOCAL, Setup, load_setup
from firstlap.recordings.recording import Recording
from firstlap.tracks.library import load_track

if TYPE_CHECKING:
    from firstlap.evaluation.ablation.measure import Ablation, Job

DEFAULT_SETUPS = (DEFAULT_SETUP, "brisk")
PAPER, FULL = "paper_base", "base"
"""First and last setup of --from-paper."""

TracksArgument = Annotated[
    list[str], typer.Argument(metavar="TRACK", help="Tracks as for `survey`, raced in both directions.")
]
RulesOption = Annotated[list[str] | None, typer.Option("--rule", metavar="NAME", help="Only this rule; repeatable.")]
AtOnceOption = Annotated[bool, typer.Option("--together", help="Turn the rules of --rule off together, as one row.")]
FromPaperOption = Annotated[
    bool,
    typer.Option("--from-paper", help="Start from paper_base and turn our additions on, one more in each row."),
]
SetupsOption = Annotated[
    list[str] | None,
    typer.Option("--setup", metavar="SETUP", help=f"Repeatable; default: {' and '.join(DEFAULT_SETUPS)}."),
]
DisturbedOption = Annotated[
    int,
    typer.Option("--disturbed", min=0, help="Number of tracks, from the first on, also raced with disturbances."),
]
PerceivedOption = Annotated[
    int,
    typer.Option("--perceived", min=0, help="Number of tracks, from the first on, on which perception is evaluated."),
]
RecordingsOption = Annotated[
    list[Path] | None,
    typer.Option("--recording", metavar="FILE", help="Recording, replayed as by `replay`; repeatable."),
]
LapsOption = Annotated[int, typer.Option("--laps", min=1, max=100, help="Laps per race.")]
SeedsOption = Annotated[int, typer.Option("--seeds", min=1, max=100, help="Races per case, seeds 1 to K.")]
PlacesOption = Annotated[int, typer.Option("--places", min=1, max=100, help="Places of sudden obstacles per lap.")]
QuickOption = Annotated[
    bool, typer.Option("--quick", help="Races only: no disturbances, no perception, no recordings.")
]
StateOption = Annotated[
    Path | None,
    typer.Option("--state", metavar="FILE", help="File that keeps the results, to resume an interrupted run."),
]


def ablation(
    tracks: TracksArgument,
    rules: RulesOption = None,
    at_once: AtOnceOption = False,
    from_paper: FromPaperOption = False,
    setups: SetupsOption = None,
    disturbed: DisturbedOption = 2,
    perceived: PerceivedOption = 2,
    recordings: RecordingsOption = None,
    laps: LapsOption = 1,
    seeds: SeedsOption = 1,
    places: PlacesOption = 2,
    quick: QuickOption = False,
    state: StateOption = None,
    car: CarOption = "default",
    lidar: LidarOption = None,
    as_json: JsonOption = False,
) -> int:
    """Turn the method's rules off one at a time and measure what each contributes."""
    from firstlap.evaluation.ablation.measure import REFERENCE, Ablation, Plan
    from firstlap.evaluation.ablation.rules import additions, chosen_rules, together

    the_car = chosen_car(car, lidar)
    loaded = {spec: load_track(spec) for spec in expand(tracks)}
    specs = list(loaded)
    chosen = _setups(setups, from_paper, rules, at_once)
    plan = Plan(
        setups=chosen,
        tracks=loaded,
        disturbed=[] if quick else specs[:disturbed],
        perceived=[] if quick else specs[:perceived],
        recordings=[] if quick else _read(recordings or []),
        laps=laps,
        seeds=seeds,
        places=places,
    )
    off = additions(chosen[0], load_setup(FULL)) if from_paper else chosen_rules(rules)
    study = Ablation(plan, the_car, [together(off)] if at_once else off, state, PAPER if from_paper else REFERENCE)
    interrupted = _measure(study)
    found = {"version": __version__, "from_paper": from_paper, **study.to_dict(), "interrupted": interrupted}
    if as_json:
        print_json(found)
    else:
        _print(found)
    return fail(f"interrupted after {len(study.found)} measurements", 130) if interrupted else 0


def _setups(names: list[str] | None, from_paper: bool, rules: list[str] | None, at_once: bool) -> list[Setup]:
    """The setups to measure. Raises InputError, also for options that contradict each other."""
    if from_paper and (names or rules or at_once):
        raise InputError("--from-paper: takes neither --setup, --rule nor --together; it goes from paper_base to base")
    if at_once and not rules:
        raise InputError("--together: which rules? Expected two or more of --rule")
    chosen = [load_setup(name) for name in ([PAPER] if from_paper else names or DEFAULT_SETUPS)]
    for setup in chosen:
        if setup.driver != LOCAL:
            raise InputError(f"--setup {setup.name}: is for driver {setup.driver}; expected one for {LOCAL}")
    return chosen


def _measure(study: Ablation) -> bool:
    """Measures everything; returns whether it was interrupted."""
    with counting_bar() as bar:
        task = bar.add_task("measuring", total=sum(1 for _ in study.jobs()))

        def done(job: Job) -> None:
            bar.update(task, advance=1, description=job.rule)

        try:
            study.run(done)
        except KeyboardInterrupt:
            return True
    return False


def _read(paths: list[Path]) -> list[Recording]:
    """The readable recordings; prints why others are skipped."""
    return [recording for path in paths if (recording := _read_or_skip(path)) is not None]


def _read_or_skip(path: Path) -> Recording | None:
    from firstlap.recordings import load_recording

    try:
        return load_recording(path)
    except InputError as error:
        note(f"skipped: {error}")
        return None


def _print(found: dict[str, Any]) -> None:
    what = "one rule more in each row" if found["from_paper"] else "one rule off at a time"
    table = Table(title=escape(f"{what}, setups {', '.join(found['setups'])}"))
    table.add_column("on" if found["from_paper"] else "off", overflow="fold", min_width=14)
    for heading in ("races", "lap", "turned", "joints", "boxes", "error 2 m", "failures", "jump", "lines"):
        table.add_column(heading, justify="right")
    for row in found["rules"]:
        counts = [f"{row[kind]['passed']}/{row[kind]['cases']}" for kind in ("race", "turned", "joints", "boxes")]
        seen = row["perception"]
        table.add_row(
            escape(row["rule"]),
            counts[0],
            _number(row["lap_ratio"], 4),
            *counts[1:],
            _number(seen.get("error_2m_p95"), 3),
            _number(seen.get("failures"), 4),
            _number(row["recordings"].get("jump_p95"), 3),
            str(row["lines"]) if row["off"] else "",
        )
    console().print(table)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
