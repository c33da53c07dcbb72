"""Options, console output and errors that the commands share."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn

from firstlap.cli.process import best_effort_stderr
from firstlap.common.errors import InputError
from firstlap.common.files import LOGS, check_writable
from firstlap.config.car_file import Car, load_car, with_lidar
from firstlap.config.driver_kind import DRIVERS
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.sim.race import OPTION_FIELDS, option_name, under_conditions

TrackArgument = Annotated[
    str,
    typer.Argument(
        metavar="TRACK", help="Name of a track, a track file, random:SEED, a ROS map YAML, or a centerline CSV."
    ),
]
DriverOption = Annotated[
    str | None, typer.Option("--driver", metavar="NAME", help=f"{', '.join(DRIVERS)}; default: the setup's.")
]
SETUP_HELP = "sure, base, race, gap, ... or a YAML file"
SetupOption = Annotated[
    str | None,
    typer.Option("--setup", metavar="SETUP", help=f"{SETUP_HELP}; default: the driver's."),
]
LatencyOption = Annotated[
    str,
    typer.Option(
        "--latency", metavar="measured|fixed:MS|none", help="How the driver's compute time delays its commands."
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change one parameter of the setup; repeatable."),
]
ConditionOption = Annotated[
    list[str] | None,
    typer.Option(
        "--option",
        metavar="NAME=VALUE",
        help="Change a condition unknown to the driver, such as mu_scale=0.85 or "
        "sensors.speed_scale_error=0.1; repeatable.",
    ),
]
CarOption = Annotated[str, typer.Option("--car", metavar="CAR", help="default, nuc2, gym or a YAML file.")]
LidarOption = Annotated[
    str | None,
    typer.Option("--lidar", metavar="LIDAR", help="rplidar_a2, ld19, ... or a YAML file; default: the car's LiDAR."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print a single JSON object.")]
TracksArgument = Annotated[
    list[str],
    typer.Argument(
        metavar="TRACK", help="Tracks as for `race`; all: all our tracks; random:1-20: twenty random tracks."
    ),
]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of all randomness.")]
ReverseOption = Annotated[bool, typer.Option("--reverse", help="Drive in the opposite direction.")]
BothOption = Annotated[bool, typer.Option("--both", help="Race in both directions.")]
LapsOption = Annotated[
    int, typer.Option("--laps", min=1, max=100_000, help="Number of laps, including the standing-start lap.")
]


def fail(message: str, code: int) -> int:
    """Prints a one-line error on stderr; returns the exit code."""
    with best_effort_stderr():
        print("error: " + " ".join(message.split()), file=sys.stderr, flush=True)
    return code


def chosen_setup(setup: str | None, changes: list[str] | None, driver: str | None = None) -> Setup:
    """The setup selected by --driver and --setup, with the changes of --set. Raises InputError."""
    loaded = choose_setup(driver, setup)
    return loaded.with_assignments(changes) if changes else loaded


def chosen_options(assignments: list[str] | None, car: Car) -> dict[str, float]:
    """The conditions of --option, without those that have their own option. Raises InputError, also if they contradict
    each other or the car."""
    chosen: dict[str, float] = {}
    for text in assignments or []:
        field, value = OPTION_FIELDS.parse_assignment(text, "--option", "mu_scale=0.85")
        if field.key in ("race.laps", "race.record_path"):
            instead = "use --laps" if field.name == "laps" else "every race records its path"
            raise InputError(f"--option {text[:60]}: {field.name} cannot be set here; {instead}")
        chosen[option_name(field)] = value
    under_conditions(car, chosen, "--option")
    return chosen


def chosen_car(car: str, lidar: str | None) -> Car:
    """The car selected by --car, with the LiDAR selected by --lidar. Raises InputError."""
    return with_lidar(load_car(car), lidar)


def described_options(options: Mapping[str, float]) -> str:
    """The options as ", NAME VALUE" each, for titles."""
    return "".join(f", {name} {value:g}" for name, value in options.items())


def refuse(options: Mapping[str, object], where: str) -> None:
    """Raises InputError for the first option that was given (is not None), since it has no effect there."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{name}: has no effect {where}")


def check_outputs(plot: Path | None = None, record: Path | None = None) -> None:
    """Raises InputError before the work if the file of --plot or --record cannot be written."""
    from firstlap.plots.primitives import PICTURE_SUFFIXES

    if plot is not None:
        check_writable(plot, PICTURE_SUFFIXES)
    if record is not None:
        check_writable(record, LOGS)


def draw(plot: Path | None, write: Callable[[Path], object], as_json: bool) -> None:
    """Writes the plot of --plot; called after the results are printed, so that a failure does not lose them.
    Raises InputError."""
    if plot is None:
        return
    write(plot)
    if not as_json:
        console().print(escape(f"plot: {plot}"), soft_wrap=True)


def print_json(data: dict[str, Any]) -> None:
    """Prints one JSON object on stdout."""
    print(json.dumps(data, indent=2, allow_nan=False))


def console() -> Console:
    """The console on stdout, for tables."""
    return Console(highlight=False)


@contextmanager
def progress_bar(*columns: str | ProgressColumn) -> Iterator[Progress]:
    """A progress bar on stderr, shown only on a terminal."""
    on_terminal = sys.stderr.isatty()
    layout = columns or (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*layout, console=Console(stderr=True), transient=True, disable=not on_terminal) as bar:
        yield bar


def counting_bar() -> Any:
    """A progress bar that counts, with the remaining time."""
    return progress_bar(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())


def note(text: str) -> None:
    """Prints a remark on stderr."""
    with best_effort_stderr():
        Console(stderr=True, highlight=False, soft_wrap=True).print(f"[dim]{escape(text)}[/dim]")
