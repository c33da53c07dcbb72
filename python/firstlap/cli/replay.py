"""firstlap replay"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import DriverOption, JsonOption, SetOption, check_outputs, console, draw, note, print_json
from firstlap.cli.map_comparison import compare_with_map, print_against_map
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
    read,
    scan_progress,
    scans_bar,
    setup_and_car,
    topics_of,
)
from firstlap.common.text import UNKNOWN, counted, short_name
from firstlap.config.setup_file import LOCAL, choose_setup
from firstlap.recordings import Recording, Topics

RecordingArgument = Annotated[
    Path, typer.Argument(metavar="RECORDING", help="A rosbag2 folder, .mcap, .db3, .bag or .npz file.")
]
AgainstOption = Annotated[str | None, typer.Option("--against", metavar="SETUP", help="A second setup for comparison.")]
BeginOption = Annotated[
    float | None, typer.Option("--from", metavar="S", help="Start, in seconds after the first scan.")
]
EndOption = Annotated[float | None, typer.Option("--to", metavar="S", help="End, in seconds after the first scan.")]
PlotOption = Annotated[
    Path | None, typer.Option("--plot", metavar="FILE", help="Plot over time; with --map: on the map.")
]
MapPathOption = Annotated[
    Path | None, typer.Option("--map", metavar="MAP", help="Compare the perception with this map; needs poses.")
]
RecordOption = Annotated[
    Path | None, typer.Option("--record", metavar="FILE.mcap", help="Log scans and plans as ROS messages.")
]
EstimateOption = Annotated[
    bool, typer.Option("--estimate", help="Estimate the state from wheel speed, IMU and steering angle.")
]


def replay(
    recording: RecordingArgument,
    driver: DriverOption = None,
    setup: SetupOfRecording = None,
    changes: SetOption = None,
    against: AgainstOption = None,
    begin: BeginOption = None,
    end: EndOption = None,
    plot: PlotOption = None,
    map_path: MapPathOption = None,
    record: RecordOption = None,
    scan_topic: ScanTopic = None,
    odom_topic: OdomTopic = None,
    imu_topic: ImuTopic = None,
    drive_topic: DriveTopic = None,
    pose_topic: PoseTopic = None,
    speed: SpeedOption = None,
    laser: LaserOption = None,
    car: CarOfRecording = None,
    keep_body: KeepBody = False,
    estimate: EstimateOption = False,
    as_json: JsonOption = False,
) -> int:
    """Run the planner on a recording: what would it have commanded?"""
    from dataclasses import replace

    from firstlap.evaluation.replay.replay import replay as run_replay
    from firstlap.recordings.load import load_libraries

    load_libraries()
    check_outputs(plot, record)
    topics = topics_of(scan_topic, odom_topic, imu_topic, drive_topic, pose_topic, speed, laser)
    other = choose_setup(None, against) if against is not None else None
    loaded, reading = _read(recording, topics, begin, end)
    chosen, loaded_car, remarks = setup_and_car(loaded, driver, setup, changes, car)
    with scans_bar() as bar:
        on_progress = scan_progress(bar, "replaying", len(loaded) * (1 if other is None else 2))
        found = run_replay(
            loaded,
            chosen,
            loaded_car,
            against=other,
            mask_body=not keep_body,
            estimated=estimate,
            on_progress=on_progress,
            record=record,
        )
    found = replace(found, reading=reading, remarks=(*remarks, *found.remarks))
    on_map = compare_with_map(loaded, chosen, loaded_car, map_path, not keep_body) if map_path else None
    _show(found.to_dict(), on_map.to_dict() if on_map else None, record, as_json)
    draw(plot, on_map.plot if on_map else found.plot, as_json)
    return 0


def _read(recording: Path, topics: Topics, begin: float | None, end: float | None) -> tuple[Recording, float]:
    """This part of the recording, and how long reading took [s]. Raises InputError."""
    started = time.perf_counter()
    loaded = read(recording, topics).between(begin, end)
    return loaded, time.perf_counter() - started


def _show(found: dict[str, Any], on_map: dict[str, Any] | None, record: Path | None, as_json: bool) -> None:
    if as_json:
        print_json(found | ({"against_map": on_map} if on_map else {}))
        return
    _print(found, record)
    if on_map:
        print_against_map(on_map)


def _print(found: dict[str, Any], record: Path | None) -> None:
    for remark in found["remarks"]:
        note(remark)
    out = console()
    table = Table(
        title=escape(f"{short_name(found['recording'])}: {counted(found['scans'], 'scan')}, {found['seconds']:.1f} s")
    )
    table.add_column("", overflow="fold")
    drives = [found, *([found["against"]] if "against" in found else [])]
    for drive in drives:
        other = "" if drive["driver"] == LOCAL else f"{drive['driver']}, "
        table.add_column(escape(f"{other}setup {drive['setup']}"), justify="right", overflow="fold")
    rows = _rows(drives)
    missing = [label.partition(":")[0] for label, cells in rows if set(cells) == {UNKNOWN}]
    for label, cells in rows:
        if set(cells) != {UNKNOWN}:
            table.add_row(label, *cells)
    out.print(table)
    if missing:
        drivers = ", ".join(dict.fromkeys(drive["driver"] for drive in drives))
        out.print(escape(f"not available for {drivers}: {', '.join(missing)}"), soft_wrap=True)
    if found["recorded"]:
        text = f"compared with the commands of {found['recorded']['topic']}: {_difference(found['recorded'])}"
        out.print(escape(text), soft_wrap=True)
    if "difference" in found:
        text = f"{drives[0]['setup']} compared with {drives[1]['setup']}: {_difference(found['difference'])}"
        out.print(escape(text), soft_wrap=True)
    sources = ", ".join(f"{name.replace('_', ' ')} from {source}" for name, source in found["sources"].items())
    out.print(escape(sources), soft_wrap=True)
    out.print(f"{found['scans_per_second']:.0f} scans per second, including reading")
    if record:
        out.print(escape(f"log: {record}"), soft_wrap=True)


def _rows(drives: list[dict[str, Any]]) -> list[tuple[str, list[str]]]:
    rows: dict[str, Callable[[dict[str, Any]], str]] = {
        "status": lambda d: ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in d["statuses"].items()),
        "visible walls: both, one, none": lambda d: _percents(d["sides"]),
        "width: 5 %, median, 95 %": lambda d: _values(d["width"], ("p5", "median", "p95"), 2, "m"),
        "path reaches 1, 2, 3 m": lambda d: _percents(d["available"]),
        "path jump: median, 95 %": lambda d: _values(d["jump"], ("median", "p95"), 3, "m"),
        "path jumps above 0.15 m": lambda d: _percent(d["jump"]["big"]),
        "changes of side": lambda d: _changes(d["changes_of_side"]),
        "a step: p50, p99": lambda d: _values(d["step_us"], ("median", "p99"), 0, "µs"),
    }
    return [(label, [text(drive) for drive in drives]) for label, text in rows.items()]


def _changes(found: dict[str, Any]) -> str:
    return UNKNOWN if found["share"] is None else f"{found['count']}, {_percent(found['share'])}"


def _percents(found: dict[str, float | None]) -> str:
    if all(value is None for value in found.values()):
        return UNKNOWN
    return ", ".join(_percent(value) for value in found.values())


def _difference(found: dict[str, Any]) -> str:
    angle = _values(_degrees(found["steering_angle"]), ("median", "p95"), 1, "°")
    speed = _values(found["speed"], ("median", "p95"), 2, "m/s")
    differences = (("steering angle", angle), ("speed", speed))
    texts = [f"{what} {UNKNOWN}" if by == UNKNOWN else f"{what} difference {by}" for what, by in differences]
    return f"{', '.join(texts)} (median, 95 %)"


def _percent(value: float | None) -> str:
    return UNKNOWN if value is None else f"{100.0 * value:.1f} %"


def _degrees(found: dict[str, Any]) -> dict[str, Any]:
    return {name: None if value is None else math.degrees(value) for name, value in found.items()}


def _values(found: dict[str, Any], names: tuple[str, ...], digits: int, unit: str) -> str:
    if all(found[name] is None for name in names):
        return UNKNOWN
    space = "" if unit == "°" else " "
    values = ", ".join(UNKNOWN if found[name] is None else f"{found[name]:.{digits}f}" for name in names)
    return f"{values}{space}{unit}"
