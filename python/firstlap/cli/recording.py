"""Options and functions that the commands for recordings share."""

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

ScanTopic = Annotated[
    str | None, typer.Option("--scan-topic", metavar="TOPIC", help="LaserScan topic, if there are several.")
]
OdomTopic = Annotated[str | None, typer.Option("--odom-topic", metavar="TOPIC", help="Odometry topic, or none.")]
ImuTopic = Annotated[
    str | None,
    typer.Option("--imu-topic", metavar="TOPIC", help="Imu topic, or none; if given, its yaw rate has priority."),
]
DriveTopic = Annotated[
    str | None, typer.Option("--drive-topic", metavar="TOPIC", help="Ackermann command topic, or none.")
]
PoseTopic = Annotated[
    str | None, typer.Option("--pose-topic", metavar="TOPIC", help="Pose topic, e.g. in a map, or none.")
]
SpeedOption = Annotated[
    float | None,
    typer.Option("--speed", metavar="M/S", help="Speed for a recording without any speed information; default: 1."),
]
LaserOption = Annotated[
    str | None,
    typer.Option(
        "--laser",
        metavar="X,Y,YAW[,ROLL]",
        help="LiDAR mounting: meters ahead and left of base_link, degrees; roll 180: upside down. "
        "Default: from /tf_static.",
    ),
]
SetupOfRecording = Annotated[
    str | None, typer.Option("--setup", metavar="SETUP", help=f"{SETUP_HELP}; default: the log's, or the driver's.")
]
CarOfRecording = Annotated[
    str | None, typer.Option("--car", metavar="CAR", help="default, nuc2, gym or a YAML file; default: the log's car.")
]
KeepBody = Annotated[bool, typer.Option("--keep-body", help="Do not mask returns from the car itself.")]

SPEED_MAX = 50.0
"""[m/s] Maximum plausible speed of a car of this size."""


def read(path: Path, topics: Topics) -> Recording:
    """Loads the recording with a progress bar. Raises InputError."""
    if topics.speed is not None and not 0.0 <= topics.speed <= SPEED_MAX:
        raise InputError(f"--speed {topics.speed:g}: allowed is 0 to {SPEED_MAX:g} m/s")
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
    """The topics, speed and mounting that the options select. Raises InputError."""
    return Topics(scan, odom, imu, drive, pose, speed, None if laser is None else parse_laser(laser))


def given_options(topics: Topics, keep_body: bool = False) -> dict[str, object]:
    """The options of a recording by name; None for those that were not given."""
    names = ("scan", "odom", "imu", "drive", "pose")
    return {
        **{f"--{name}-topic": getattr(topics, name) for name in names},
        "--speed": topics.speed,
        "--laser": topics.laser,
        "--keep-body": keep_body or None,
    }


def scan_progress(bar: Progress, description: str, scans: int) -> Callable[[int], object]:
    """Adds a task to the bar; returns the callback that updates it with the number of scans done."""
    task = bar.add_task(description, total=scans)
    return lambda done: bar.update(task, completed=done)


def scans_bar() -> Any:
    """A progress bar that counts scans."""
    return progress_bar(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())


def setup_and_car(
    recording: Recording, driver: str | None, setup: str | None, changes: list[str] | None, car: str | None
) -> tuple[Setup, Car, list[str]]:
    """The setup and the car that were given, else those of the log, else the defaults; and remarks on what came from
    the log.

    driver: None selects the log's driver, or the setup's.
    """
    about, remarks = recording.about, []
    if about is not None and setup is None and driver is None:
        chosen = about.setup
        remarks.append(f"{chosen.title}, from the log")
    else:
        chosen = choose_setup(driver, setup)
    if about is not None and chosen.driver != about.setup.driver:
        remarks.append(f"driven by {about.setup.driver}; replayed with {chosen.driver}")
    if about is not None and car is None:
        remarks.append(f"car {about.car.name}, from the log")
    if changes:
        chosen = chosen.with_assignments(changes)
    loaded = load_car(car) if car is not None else about.car if about is not None else load_car("default")
    return chosen, loaded, remarks
