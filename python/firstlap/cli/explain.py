"""firstlap explain"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from firstlap.cli.common import (
    DriverOption,
    LidarOption,
    ReverseOption,
    SeedOption,
    SetOption,
    check_outputs,
    chosen_car,
    chosen_setup,
    console,
    note,
    refuse,
)
from firstlap.cli.recording import (
    CarOfRecording,
    DriveTopic,
    ImuTopic,
    KeepBody,
    LaserOption,
    OdomTopic,
    PoseTopic,
    ScanTopic,
    SetupOfRecording,
    SpeedOption,
    given_options,
    read,
    setup_and_car,
    topics_of,
)
from firstlap.common.errors import InputError
from firstlap.explain.snapshot import StepSnapshot
from firstlap.tracks.library import load_track

WhatArgument = Annotated[
    str | None, typer.Argument(metavar="TRACK|RECORDING", help="A track as for `race`, or with --scan a recording.")
]
AtOption = Annotated[float | None, typer.Option("--at", metavar="METERS", help="Distance from the start line.")]
ScanOption = Annotated[
    str | None,
    typer.Option("--scan", metavar="K|FILE", help="Number of the scan in RECORDING (-1: last), or the recording."),
]
IndexOption = Annotated[int, typer.Option("--index", metavar="K", help="Number of the scan in --scan FILE.")]
PlotOption = Annotated[Path, typer.Option("--plot", metavar="FILE", help="Output file of the plot.")]


def explain(
    what: WhatArgument = None,
    at: AtOption = None,
    scan: ScanOption = None,
    index: IndexOption = 0,
    driver: DriverOption = None,
    setup: SetupOfRecording = None,
    changes: SetOption = None,
    seed: SeedOption = 1,
    reverse: ReverseOption = False,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    imu_topic: ImuTopic = None,
    drive_topic: DriveTopic = None,
    pose_topic: PoseTopic = None,
    speed: SpeedOption = None,
    laser: LaserOption = None,
    car: CarOfRecording = None,
    lidar: LidarOption = None,
    keep_body: KeepBody = False,
    plot: PlotOption = Path("explain.png"),
) -> int:
    """Plot one step of a driver: scan, plan and steering terms."""
    from firstlap.explain.snapshot import explain_race, explain_recording
    from firstlap.explain.step_plots import plot_step

    recording_file, index = _recording(what, at, scan, index)
    check_outputs(plot)
    topics = topics_of(scan_topic, odom_topic, imu_topic, drive_topic, pose_topic, speed, laser)
    if recording_file is None:
        refuse(given_options(topics, keep_body), "with a track")
        snapshot = explain_race(
            load_track(str(what)),
            chosen_setup(setup, changes, driver),
            chosen_car("default" if car is None else car, lidar),
            at or 0.0,
            seed=seed,
            reverse=reverse,
        )
    else:
        if lidar is not None:
            raise InputError("--lidar: has no effect with a recording, which has its own; --laser sets its mounting")
        refuse({"--reverse": reverse or None}, "with a recording")
        recording = read(recording_file, topics)
        chosen, loaded_car, remarks = setup_and_car(recording, driver, setup, changes, car)
        snapshot = explain_recording(recording, chosen, loaded_car, index, mask_body=not keep_body)
        for remark in remarks:
            note(remark)
    plot_step(snapshot, plot)
    _print(snapshot, plot)
    return 0


def _recording(what: str | None, at: float | None, scan: str | None, index: int) -> tuple[Path | None, int]:
    """The recording, if any, and the index of its scan: `RECORDING --scan K` or `--scan FILE --index K`."""
    number = re.fullmatch(r"[+-]?[0-9]{1,9}", scan or "")
    if (at is not None and scan is not None) or (what is None) == (scan is None or number is not None):
        raise InputError("expected TRACK with --at METERS, RECORDING with --scan K, or --scan FILE with --index K")
    if scan is None:
        return None, index
    return (Path(str(what)), int(scan)) if number else (Path(scan), index)


def _print(snapshot: StepSnapshot, plot: Path) -> None:
    for remark in snapshot.remarks:
        note(remark)
    out = console()
    if snapshot.outcome:
        out.print(f"[yellow]the race ended earlier: {snapshot.outcome}; this is its last step[/]")
    out.print(escape(f"plot: {plot}"), soft_wrap=True)
