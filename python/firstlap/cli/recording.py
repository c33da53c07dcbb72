"""What the commands that read a recording share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from firstlap.cli.common import SETUP_HELP, progress_bar
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, load_car
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.recordings import Recording, Topics, load_recording
from firstlap.recordings.laser import parse_laser

ScanTopic = Annotated[str | None, typer.Option("--scan-topic", metavar="TOPIC", help="LaserScan, where there are two.")]
OdomTopic = Annotated[str | None, typer.Option("--odom-topic", metavar="TOPIC", help="Odometry, or none.")]
ImuTopic = Annotated[
    str | None, typer.Option("--imu-topic", metavar="TOPIC", help="Imu, or none; named, its yaw rate counts first.")
]
DriveTopic = Annotated[
    str | None, typer.Option("--drive-topic", metavar="TOPIC", help="The recorded Ackermann commands, or none.")
]
PoseTopic = Annotated[str | None, typer.Option("--pose-topic", metavar="TOPIC", help="Poses, e.g. in a map, or none.")]
SpeedOption = Annotated[
    float | None, typer.Option("--speed", metavar="M/S", help="For a recording that tells no speed at all; default: 1.")
]
LaserOption = Annotated[
    str | None,
    typer.Option(
        "--laser",
        metavar="X,Y,YAW[,ROLL]",
        help="Where the laser is mounted: meters ahead and left of base_link, degrees; roll 180: upside down. "
        "Default: /tf_static's.",
    ),
]
SetupOfRecording = Annotated[
    str | None, typer.Option("--setup", metavar="SETUP", help=f"{SETUP_HELP}; else a log's, or the driver's.")
]
CarOfRecording = Annotated[
    str | None, typer.Option("--car", metavar="CAR", help="default, nuc2, gym or a YAML file; else a log's own.")
]
KeepBody = Annotated[bool, typer.Option("--keep-body", help="Do not mask returns of the car itself that are found.")]

FASTEST = 50.0
"""[m/s] that any car of this size may have gone."""


def read(path: Path, topics: Topics) -> Recording:
    """The recording, with a bar while it is read. Raises InputError."""
    if topics.speed is not None and not 0.0 <= topics.speed <= FASTEST:
        raise InputError(f"--speed {topics.speed:g}: allowed is 0 to {FASTEST:g} m/s")
    with progress_bar(TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed} messages")) as bar:
        task = bar.add_task("reading", total=None)
        return load_recording(path, topics, lambda count: bar.update(task, completed=count))


def topics_of(
    scan: str | None,
    odom: str | None,
    imu: str | None,
    drive: str | None,
    pose: str | None,
    speed: float | None,
    laser: str | None,
) -> Topics:
    """What the options say of a recording. Raises InputError."""
    return Topics(scan, odom, imu, drive, pose, speed, None if laser is None else parse_laser(laser))


def given(topics: Topics, keep_body: bool = False) -> dict[str, object]:
    """The options that say what is read of a recording, by name; None where one was not given."""
    names = ("scan", "odom", "imu", "drive", "pose")
    return {
        **{f"--{name}-topic": getattr(topics, name) for name in names},
        "--speed": topics.speed,
        "--laser": topics.laser,
        "--keep-body": keep_body or None,
    }


def watched(bar: Progress, description: str, scans: int) -> Callable[[int], object]:
    """A `look` that moves a bar of scans."""
    task = bar.add_task(description, total=scans)
    return lambda done: bar.update(task, completed=done)


def scans_bar() -> Any:
    """A bar that counts scans."""
    return progress_bar(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())


def setup_and_car(
    recording: Recording, driver: str | None, setup: str | None, changes: list[str] | None, car: str | None
) -> tuple[Setup, Car, list[str]]:
    """Those asked for, else those of the log, else the defaults; with a remark where they are the log's.

    driver: None for that of the log, or whatever the setup is for.
    """
    about, remarks = recording.about, []
    if about is not None and setup is None and driver is None:
        chosen = about.setup
        remarks.append(f"{chosen.title} as the log has it")
    else:
        chosen = choose_setup(driver, setup)
    if about is not None and chosen.driver != about.setup.driver:
        remarks.append(f"driven by {about.setup.driver}; what {chosen.driver} would have done")
    if about is not None and car is None:
        remarks.append(f"car {about.car.name} as the log has it")
    if changes:
        chosen = chosen.with_assignments(changes)
    loaded = load_car(car) if car is not None else about.car if about is not None else load_car("default")
    return chosen, loaded, remarks
