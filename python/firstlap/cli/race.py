"""firstlap race"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from firstlap import _core
from firstlap.cli.common import (
    CarOption,
    ConditionOption,
    DriverOption,
    JsonOption,
    LapsOption,
    LatencyOption,
    LidarOption,
    ReverseOption,
    SeedOption,
    SetOption,
    SetupOption,
    TrackArgument,
    check_outputs,
    chosen_car,
    chosen_options,
    chosen_setup,
    console,
    described_options,
    draw,
    note,
    print_json,
    progress_bar,
)
from firstlap.common.errors import InputError
from firstlap.common.text import short_name
from firstlap.config.driver_kind import ProgressCallback
from firstlap.config.setup_file import Setup
from firstlap.sim.race import RaceResult, latency_options
from firstlap.sim.race import race as run_race
from firstlap.tracks.library import load_track

TruePoseOption = Annotated[
    bool, typer.Option("--true-pose", help="Ablation of `global`: use the simulator's true pose.")
]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot the race.")]
RecordOption = Annotated[
    Path | None, typer.Option("--record", metavar="FILE.mcap", help="Log the race as ROS messages.")
]


def race(
    track: TrackArgument,
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    laps: LapsOption = 3,
    seed: SeedOption = 1,
    reverse: ReverseOption = False,
    car: CarOption = "default",
    lidar: LidarOption = None,
    options: ConditionOption = None,
    latency: LatencyOption = "none",
    true_pose: TruePoseOption = False,
    plot: PlotOption = None,
    record: RecordOption = None,
    as_json: JsonOption = False,
) -> int:
    """Race one track: lap times, clearance, and a plot. Exit code 0 if the race finished, 1 otherwise."""
    check_outputs(plot, record)
    chosen = chosen_setup(setup, changes, driver)
    if true_pose:
        chosen = _with_true_pose(chosen)
    latency_options(latency)
    loaded_car = chosen_car(car, lidar)
    conditions = chosen_options(options, loaded_car)
    loaded = load_track(track)

    def drive(on_progress: Callable[[_core.Race], object], preparing: ProgressCallback) -> RaceResult:
        return run_race(
            loaded,
            chosen,
            loaded_car,
            laps=laps,
            seed=seed,
            reverse=reverse,
            latency=latency,
            options=conditions,
            on_progress=on_progress,
            preparing=preparing,
            record=record,
        )

    result = _drive_with_progress(drive, laps, loaded.length)
    if as_json:
        print_json(result.to_dict())
    else:
        _print(result, record)
    draw(plot, result.plot, as_json)
    return 0 if result.finished else 1


def _with_true_pose(setup: Setup) -> Setup:
    if "guard.true_pose" not in [entry.key for entry in setup.fields.fields]:
        raise InputError(f"--true-pose: driver {setup.driver} uses no pose; expected --driver global")
    return setup.with_values({"guard.true_pose": True})


def _drive_with_progress(
    drive: Callable[[Callable[[_core.Race], object], ProgressCallback], RaceResult], laps: int, length: float
) -> RaceResult:
    columns = (TextColumn("{task.description}"), BarColumn(50), TextColumn("{task.fields[speed]:.1f} m/s"))
    with progress_bar(*columns) as bar:
        task = bar.add_task(f"lap 1 of {laps}", total=laps * length, speed=0.0)

        def on_progress(running: _core.Race) -> None:
            _show(bar, task, running, laps)

        def preparing(what: str, share: float) -> None:
            bar.update(task, description=what, completed=share * laps * length)

        return drive(on_progress, preparing)


def _show(bar: Progress, task: int, running: _core.Race, laps: int) -> None:
    done = running.laps_done()
    bar.update(
        task,  # type: ignore[arg-type]
        description=f"lap {min(done + 1, laps)} of {laps}",
        completed=done * running.track_length + running.s,
        speed=running.state().speed,
    )


def _print(result: RaceResult, record: Path | None) -> None:
    for remark in result.track.notes:
        note(remark)
    direction = ("" if result.direction == "forward" else ", reverse") + described_options(result.options)
    table = Table(
        title=escape(f"{short_name(result.track.name)}, {result.track.length:.1f} m{direction}, {result.setup.title}")
    )
    for heading in ("lap", "time s", "mean m/s", "top m/s", "clearance m", ""):
        table.add_column(heading, justify="right")
    for number, lap in enumerate(result.laps, start=1):
        remark = "standing start" if lap.standing else "best" if lap.time == result.best else ""
        table.add_row(
            str(number),
            f"{lap.time:.2f}",
            f"{lap.mean_speed:.2f}",
            f"{lap.max_speed:.2f}",
            f"{lap.min_clearance:.2f}",
            remark,
        )
    out = console()
    out.print(table)
    if result.contact:
        where = f"at {result.contact.time:.2f} s, {result.contact.s:.1f} m into the lap"
        out.print(f"[bold red]contact[/] {where} (x {result.contact.x:.2f}, y {result.contact.y:.2f})")
    elif not result.finished:
        why = f": {escape(result.ending.said)}" if result.ending else ""
        out.print(f"[bold red]{result.outcome.replace('_', ' ')}[/] after {result.time:.2f} s{why}", soft_wrap=True)
    before = result.preparation
    if before.seconds:
        kept = ", from the cache" if before.cached else ""
        out.print(f"preparation: {before.driving:.1f} s of driving, {before.computing:.1f} s of computing{kept}")
        for remark in before.notes:
            note(remark)
    compute = result.compute
    if compute["p50"] is not None:
        out.print(f"a step took {compute['p50']:.0f} µs (p50), {compute['p99']:.0f} µs (p99)")
    if result.skipped_scans:
        out.print(f"skipped: {result.skipped_scans} scans arrived while the driver was busy")
    if record:
        out.print(escape(f"log: {record}"), soft_wrap=True)
