"""firstlap map"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    CarOption,
    JsonOption,
    LidarOption,
    SeedOption,
    SetupOption,
    check_outputs,
    chosen_car,
    chosen_setup,
    console,
    draw,
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
    ScanTopic,
    SpeedOption,
    given_options,
    read,
    topics_of,
)
from firstlap.common.errors import InputError
from firstlap.common.files import check_writable
from firstlap.common.text import short_name
from firstlap.common.version import __version__
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.config.car_file import Car
    from firstlap.mapping.make import MappingProgress, MapResult
    from firstlap.recordings import Recording, Topics

SourceArgument = Annotated[
    str, typer.Argument(metavar="TRACK|RECORDING", help="A track as for `race`, or a recording with odometry.")
]

OutputOption = Annotated[
    Path, typer.Option("-o", "--output", metavar="MAP", help="Output YAML; the PGM is written next to it.")
]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change one parameter of mapping; repeatable."),
]
CheckOption = Annotated[bool, typer.Option("--check", help="Compare the map with the track's true walls.")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot the map.")]


def map_command(
    source: SourceArgument,
    output: OutputOption,
    setup: SetupOption = None,
    changes: ChangesOption = None,
    car: CarOption = "default",
    lidar: LidarOption = None,
    seed: SeedOption = 1,
    check: CheckOption = False,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    imu_topic: ImuTopic = None,
    drive_topic: DriveTopic = None,
    speed: SpeedOption = None,
    laser: LaserOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> int:
    """Make an occupancy map from one slow lap or a recording by scan matching and loop closure."""
    from firstlap.drivers.mapping_drive import map_track
    from firstlap.mapping.contradictions import contradictions
    from firstlap.mapping.make import map_observations
    from firstlap.mapping.occupancy_map import MAP_SUFFIXES, write_map
    from firstlap.mapping.parameters import map_settings
    from firstlap.mapping.recording import observations
    from firstlap.recordings.laser import car_of
    from firstlap.recordings.paths import is_recording

    check_writable(output, MAP_SUFFIXES)
    check_writable(output.with_suffix(".pgm"), (".pgm",))
    check_outputs(plot)
    settings, the_car, chosen = map_settings(changes), chosen_car(car, lidar), chosen_setup(setup, None)
    topics = topics_of(scan_topic, odom_topic, imu_topic, drive_topic, None, speed, laser)
    subject = _recording(source, topics, lidar, check) if is_recording(source) else _track(source, topics)
    with _mapping() as on_progress:
        if isinstance(subject, Track):
            result = map_track(subject, chosen, the_car, seed=seed, settings=settings, on_progress=on_progress)
        else:
            mounted, total = car_of(subject, the_car), len(subject)
            result = map_observations(
                observations(subject), mounted, name=source, total=total, settings=settings, on_progress=on_progress
            )
        picture = write_map(result.map, output)
    found: dict[str, Any] = {"version": __version__, "source": source, "map": str(output), **result.to_dict()}
    if check and isinstance(subject, Track):
        found["error"] = _error(result, subject, the_car)
    remarks = () if isinstance(subject, Track) else (*subject.remarks, *contradictions(subject, the_car))
    found["remarks"] = list(remarks)
    if as_json:
        print_json(found)
    else:
        for remark in remarks:
            note(remark)
        _print(found, picture)
    draw(plot, lambda path: _draw(result, path, source), as_json)
    return 0


def _recording(source: str, topics: Topics, lidar: str | None, check: bool) -> Recording:
    """The recording to map. Raises InputError."""
    from firstlap.mapping.recording import check_odometry

    if check:
        raise InputError(f"{source}: --check needs a track, whose true walls are known, not a recording")
    refuse({"--lidar": lidar}, "with a recording")
    recording = read(Path(source), topics)
    check_odometry(recording)
    return recording


def _track(source: str, topics: Topics) -> Track:
    """The track to map. Raises InputError."""
    refuse(given_options(topics), "with a track")
    return load_track(source)


@contextmanager
def _mapping() -> Iterator[MappingProgress]:
    """Shows a progress bar; yields the callback that updates it."""
    with progress_bar() as bar:
        task = bar.add_task("mapping", total=1.0)

        def on_progress(what: str, done: float, total: float) -> None:
            bar.update(task, description=what, completed=done, total=total)

        yield on_progress


def _error(result: MapResult, track: Track, car: Car) -> dict[str, Any]:
    """The deviation of the map from the track's true walls."""
    from firstlap.evaluation.map_accuracy import check_map, true_start

    return check_map(result.map, track, true_start(track, car)).to_dict()


def _draw(result: MapResult, plot: Path, source: str) -> None:
    from firstlap.mapping.plot import plot_map

    found = result.to_dict()
    details = f"{found['travelled']:.1f} m driven   ·   {found['kept_scans']} scans   ·   {found['loops']} loops"
    plot_map(result, plot, short_name(source), details)


def _print(found: dict[str, Any], picture: Path) -> None:
    table = Table(title=escape(f"map of {short_name(found['source'])}"), show_header=False)
    table.add_row("driven", f"{found['travelled']:.1f} m, loop closed at {found['loop_closed_at']:.1f} m")
    table.add_row("scans", f"{found['scans']}, {found['kept_scans']} kept")
    table.add_row("matches", f"{found['matches']}, {found['loops']} across the loop")
    table.add_row("loop correction", f"{found['moved_by_loop']:.3f} m maximum")
    table.add_row("size", f"{found['columns']} x {found['rows']} cells of {found['resolution']:g} m")
    if "error" in found:
        error = found["error"]
        table.add_row("wall error", f"{error['rms']:.3f} m rms, {error['p95']:.3f} m p95 (best rigid fit)")
        table.add_row("", f"{error['rms_start']:.3f} m rms (aligned at the true start)")
        table.add_row("true walls found", f"{100 * error['complete']:.1f} %")
    out = console()
    out.print(table)
    out.print(escape(f"map: {found['map']} and {picture}"), soft_wrap=True)
