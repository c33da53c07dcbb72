"""firstlap localize"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap import _core
from firstlap.cli.common import (
    SETUP_HELP,
    CarOption,
    JsonOption,
    LidarOption,
    SeedOption,
    chosen_car,
    chosen_setup,
    console,
    note,
    print_json,
    progress_bar,
    refuse,
)
from firstlap.cli.recording import (
    DriveTopic,
    ImuTopic,
    LaserOption,
    OdomTopic,
    PoseTopic,
    ScanTopic,
    SpeedOption,
    given_options,
    read,
    scan_progress,
    scans_bar,
    topics_of,
)
from firstlap.common.errors import InputError
from firstlap.common.text import UNKNOWN, counted, short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.recordings.paths import is_recording

if TYPE_CHECKING:
    from firstlap.recordings.recording import Recording

LAPS = 3
"""Default of a race."""

WhatArgument = Annotated[
    str, typer.Argument(metavar="TRACK|RECORDING", help="A track as for `race`, or with --map a recording.")
]
MapPathOption = Annotated[
    Path | None,
    typer.Option("--map", metavar="MAP", help="Map for the localization; default for a track: made from a slow lap."),
]
SetupOption = Annotated[
    str | None, typer.Option("--setup", metavar="SETUP", help=f"For a race: {SETUP_HELP}; default: the driver's.")
]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change one parameter of localization; repeatable."),
]
LapsOption = Annotated[
    int | None, typer.Option("--laps", min=1, max=100_000, help=f"For a race: number of laps; default: {LAPS}.")
]
WrongStartOption = Annotated[
    float,
    typer.Option(
        "--wrong-start", min=0, max=10, metavar="M", help="Position error of the start pose, in any direction."
    ),
]
WrongHeadingOption = Annotated[
    float,
    typer.Option(
        "--wrong-heading", min=0, max=180, metavar="DEG", help="Heading error of the start pose, either sign."
    ),
]
KidnapOption = Annotated[
    float,
    typer.Option("--kidnap", min=0, max=10, metavar="M", help="Displace the pose estimate by this, repeatedly."),
]
EveryOption = Annotated[
    float, typer.Option("--every", min=0.5, max=1000, metavar="S", help="Interval of the displacements.")
]


def localize(
    what: WhatArgument,
    map_path: MapPathOption = None,
    setup: SetupOption = None,
    changes: ChangesOption = None,
    laps: LapsOption = None,
    seed: SeedOption = 1,
    car: CarOption = "default",
    lidar: LidarOption = None,
    wrong_start: WrongStartOption = 0.0,
    wrong_heading: WrongHeadingOption = 0.0,
    kidnap: KidnapOption = 0.0,
    every: EveryOption = 3.0,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    imu_topic: ImuTopic = None,
    drive_topic: DriveTopic = None,
    pose_topic: PoseTopic = None,
    speed: SpeedOption = None,
    laser: LaserOption = None,
    as_json: JsonOption = False,
) -> int:
    """Measure how well the particle filter localizes a racing or recorded car. Exit code 1 if the race or the filter
    fails."""
    from firstlap.localization.localizer import localizer_params

    params, the_car = localizer_params(changes), chosen_car(car, lidar)
    topics = topics_of(scan_topic, odom_topic, imu_topic, drive_topic, pose_topic, speed, laser)
    if is_recording(what):
        wrong = {"--wrong-start": wrong_start, "--wrong-heading": wrong_heading, "--kidnap": kidnap}
        refuse({"--setup": setup, "--laps": laps, "--lidar": lidar}, "with a recording")
        refuse({name: value or None for name, value in wrong.items()}, "with a recording")
        if map_path is None:
            raise InputError(f"{what}: a recording needs --map MAP, a map of its location; `firstlap map` makes one")
        return _of_recording(read(Path(what), topics), map_path, the_car, seed, params, as_json)
    refuse(given_options(topics), "with a track")
    disturbance = (wrong_start, math.radians(wrong_heading), kidnap, every)
    found = _race(what, map_path, chosen_setup(setup, None), the_car, laps or LAPS, seed, params, disturbance)
    found |= {"wrong_start": wrong_start, "wrong_heading": wrong_heading, "kidnap": kidnap}
    if as_json:
        print_json(found)
    else:
        _print(found)
    return 0 if found["outcome"] == "finished" and not found["lost_at_end"] else 1


def _race(
    track: str,
    map_path: Path | None,
    setup: Setup,
    car: Car,
    laps: int,
    seed: int,
    params: _core.LocalizerParams,
    disturbance: tuple[float, float, float, float],
) -> dict[str, Any]:
    from firstlap.drivers.mapping_drive import map_track
    from firstlap.evaluation.localization import Disturbance, follow
    from firstlap.mapping.occupancy_map import read_map
    from firstlap.tracks.library import load_track

    known_map = read_map(map_path) if map_path else None
    loaded = load_track(track)
    with progress_bar() as bar:
        task = bar.add_task("mapping lap", total=1.0)

        def on_progress(what: str, done: float, total: float) -> None:
            bar.update(task, description=what, completed=done, total=total)

        if known_map is None:
            known_map = map_track(loaded, None, car, seed=seed, on_progress=on_progress).map

        def watch(race: _core.Race) -> None:
            on_progress("localizing", race.laps_done() * race.track_length + race.s, laps * race.track_length)

        followed = follow(
            loaded,
            known_map,
            setup,
            car,
            laps=laps,
            seed=seed,
            params=params,
            disturbance=Disturbance(*disturbance),
            on_progress=watch,
        )
    return {
        "version": __version__,
        "track": loaded.name,
        "map": str(map_path or "made by a slow lap"),
        "setup": setup.name,
        "car": car.name,
        "seed": seed,
        **followed.to_dict(),
    }


def _of_recording(
    recording: Recording, map_path: Path, car: Car, seed: int, params: _core.LocalizerParams, as_json: bool
) -> int:
    from firstlap.evaluation.localization_of_recording import localize_recording, starts_of
    from firstlap.mapping.contradictions import contradictions
    from firstlap.mapping.occupancy_map import read_map
    from firstlap.recordings.laser import car_of

    known_map, mounted = read_map(map_path), car_of(recording, car)
    with scans_bar() as bar:
        on_progress = scan_progress(bar, "localizing", len(recording) * len(starts_of(recording, known_map)))
        localized = localize_recording(recording, known_map, mounted, seed=seed, params=params, on_progress=on_progress)
    found = {
        "version": __version__,
        "recording": recording.name,
        "map": str(map_path),
        "car": mounted.name,
        "seed": seed,
        **localized.to_dict(),
        "remarks": [*recording.remarks, *contradictions(recording, mounted)],
    }
    if as_json:
        print_json(found)
    else:
        _print_recording(found)
    return 1 if found["lost_at_end"] else 0


def _print_recording(found: dict[str, Any]) -> None:
    for remark in found["remarks"]:
        note(remark)
    scans = f"{counted(found['scans'], 'scan')}, {found['seconds']:.1f} s"
    out, rows = console(), [("step_us", "µs", 0)]
    if found["position"]["p50"] is not None:
        rows = [("position", "m", 3), ("heading", "°", 2), *rows]
    out.print(_table(f"{short_name(found['recording'])} on {short_name(found['map'])}, {scans}", found, rows))
    x, y, yaw = found["start"]
    place = f"{x:.2f}, {y:.2f} m, {math.degrees(yaw):.0f}°"
    out.print(f"started at {place}; {100 * found['fit']:.0f} % of a scan matches the map")
    out.print(f"lost in {100 * found['lost']:.2f} % of {found['scans']} scans; {_after('found', found['found_after'])}")
    if found["lost_at_end"]:
        out.print("[bold red]lost at the end[/]: does the map match the location, and did the car start there?")


def _table(title: str, found: dict[str, Any], rows: Sequence[tuple[str, str, int]]) -> Table:
    table = Table(title=escape(title))
    for heading in ("", "p50", "p95", "max"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, unit, digits in rows:
        row = found[name]
        values = [UNKNOWN if row[key] is None else f"{row[key]:.{digits}f} {unit}" for key in ("p50", "p95", "max")]
        table.add_row("a step" if name == "step_us" else f"{name} error", *values)
    return table


def _print(found: dict[str, Any]) -> None:
    laps = counted(found["laps"], "lap")
    title = f"{short_name(found['track'])}, setup {found['setup']}, {laps}, {found['mean_speed']:.2f} m/s on average"
    out = console()
    out.print(_table(title, found, (("position", "m", 3), ("heading", "°", 2), ("step_us", "µs", 0))))
    if found["outcome"] != "finished":
        out.print(f"[bold red]the race failed: {found['outcome'].replace('_', ' ')}[/]")
    out.print(f"a step took {found['step_us']['p99']:.0f} µs (p99, CPU time)")
    out.print(f"lost in {100 * found['lost']:.2f} % of {found['scans']} scans; {_after('found', found['found_after'])}")
    if found["kidnapped"]:
        longest = _after(", the last", found["recovered_after"]) if found["recovered"] else ""
        out.print(f"kidnapped {counted(found['kidnapped'], 'time')}, recovered {found['recovered']}{longest}")
    if found["lost_at_end"]:
        out.print("[bold red]lost at the end[/]: does the map match the track?")


def _after(what: str, seconds: float | None) -> str:
    return f"{what} after {seconds:.2f} s" if seconds is not None else f"never {what}"
