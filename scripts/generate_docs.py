"""Write the generated files: the pages of parameters and results, and the type stubs. --check only compares."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from firstlap import _core
from firstlap.config.car_file import CAR_FIELDS
from firstlap.config.parameters import Field, FieldTable
from firstlap.control.mpc.params import MPC_FIELDS
from firstlap.drivers import DRIVERS, DriverKind
from firstlap.localization.localizer import LOCALIZER_FIELDS
from firstlap.mapping.parameters import MAP_FIELDS
from firstlap.planning.raceline.params import LINE_FIELDS
from firstlap.ros.names import DRIVE, FAULTS, SIM, Entry
from firstlap.sim.drivable import SEARCH_FIELDS
from firstlap.sim.race import OPTION_FIELDS
from firstlap.tuning.variation import EVALUATION_FIELDS

ROOT = Path(__file__).resolve().parents[1]
HEAD = """<!-- Written by `make docs` from the field tables. Do not edit. -->

# Parameters

Each default is defined once, in its C++ struct or, for parameters that only Python has, in its Python table. This page,
the YAML readers, the bindings and the checks loop over the field tables next to them.
"""


RESULTS_HEAD = """<!-- Written by `make docs` from the tables beside the structs. Do not edit. -->

# Results and traces

Results of races, steps and logs: names, units and meanings. Each table is defined next to its C++ struct; the Python
objects and dicts, `--json`, the columns of logs and this page loop over it. SI units; x forward, y left, angles
counterclockwise. Traces are in `base_link`, races in the map frame.
"""
RESULTS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    (
        "Inputs and commands",
        "Drivers, mapping and localization take a `firstlap._core.LaserScan` and a `VehicleState`; drivers return a "
        "`StepResult` as a tuple.",
        ("LaserScan", "VehicleState", "StepResult"),
    ),
    (
        "State estimation",
        "`Race.reading()` returns the measurements of the simulated sensors, `StateEstimate.estimate()` the motion "
        "estimated from such measurements; see [estimation.md](estimation.md).",
        ("SensorReading", "MotionEstimate"),
    ),
    (
        "Races",
        "`RaceResult` is the dict of `firstlap._core.Race.result()`. `Lap`, `Contact` and `ObstacleSeen` are "
        "objects with these attributes; `to_dict()` gives what `firstlap race --json` prints. `path` is a dict of "
        "arrays with the columns of `PathSample`.",
        ("RaceResult", "Lap", "Contact", "ObstacleSeen", "PathSample"),
    ),
    (
        "Search for a lap",
        "Dict of `firstlap._core.search_lap`; `path` is a list of tuples. See `firstlap.sim.drivable`.",
        ("LapSearchResult",),
    ),
    (
        "Trace of `local`",
        "`Racer.trace` returns a dict. A nested struct is a dict, a sequence of structs a dict of arrays, and "
        "`candidates` a list of tuples. Points are arrays (N, 2) of x, y.",
        ("Trace", "Section", "SplitCandidate", "WallSide", "Centerline", "TrajectoryPoint", "SteeringTerms"),
    ),
    (
        "Traces of `gap`, `disparity` and `pid`",
        "As above; directions are in the LiDAR's frame.",
        ("FollowTheGap", "DisparityExtender", "CenterPid", "WallEstimate"),
    ),
    ("Localization", "Returned by `Localizer.step`, an object.", ("Estimate",)),
    (
        "Steps of a log",
        "Columns of `_core.replay` and `_core.LoggedDriver`, one entry per scan. `left`, `right`, `line` and `path`"
        " hold the rows of all scans, concatenated; `left_size` etc. are the numbers of rows of each scan.",
        ("LoggedStep", "LoggedTrace", "left", "right", "line", "path"),
    ),
)


def table(fields: list[Field]) -> str:
    """One Markdown table."""
    lines = ["| name | default | range | unit | description |", "|---|---|---|---|---|"]
    for field in fields:
        default = str(field.default).lower() if field.type == "bool" else f"{field.default:g}"
        allowed = "true, false" if field.type == "bool" else f"{field.min:g} to {field.max:g}"
        unit = field.unit.replace("^2", "²")
        lines.append(f"| `{field.name}` | {default} | {allowed} | {unit} | {field.doc.replace('|', '/')} |")
    return "\n".join(lines)


def chapter(title: str, text: str, fields: FieldTable) -> str:
    """One chapter, with a table per section."""
    parts = [f"## {title}\n\n{text}"]
    for section in fields.sections:
        rows = [field for field in fields.fields if field.section == section]
        parts += [f"### {section}\n\n{table(rows)}"]
    return "\n\n".join(parts)


def driver_chapter(kind: DriverKind) -> str:
    """The setups of one driver."""
    first = "" if kind.name == "local" else f" The file starts with the line `driver: {kind.name}`."
    names = "Every name can also be set with `--set NAME=VALUE`."
    text = f"Sections of a setup file (`--setup FILE`) for the driver `{kind.name}`, {kind.title}.{first} {names}"
    if kind.name == "global":
        text += (
            " The sections are `guard`, those of the racing line (`line`) and of predictive control (`mpc`), and those"
            " of mapping and localization with the prefixes `map_` and `pose_`: `map_drive`, `pose_filter`. They are"
            " listed in the chapters below."
        )
        own = FieldTable(vars(entry) for entry in kind.fields.fields if entry.section == "guard")
        return chapter(f"Setups of `{kind.name}`", text, own)
    return chapter(f"Setups of `{kind.name}`", text, kind.fields)


def parameters() -> str:
    """docs/parameters.md"""
    return (
        "\n".join(
            [
                HEAD,
                *(part for kind in DRIVERS.values() for part in (driver_chapter(kind), "")),
                chapter(
                    "Cars",
                    "Sections of a car file (`--car FILE`). Omitted values are those of the default car, as listed.",
                    CAR_FIELDS,
                ),
                "",
                chapter(
                    "Racing line",
                    "For `firstlap line --set NAME=VALUE`, see [the racing line](racing-line.md).",
                    LINE_FIELDS,
                ),
                "",
                chapter("Predictive control", "Parameters of the controller that tracks a racing line.", MPC_FIELDS),
                "",
                chapter(
                    "Races",
                    "Options of `firstlap.race(..., options={...})`.",
                    OPTION_FIELDS,
                ),
                "",
                chapter(
                    "Search for a lap",
                    "`firstlap tracks --drivable --margin M`, and options of `firstlap.sim.drivable.search_lap`.",
                    SEARCH_FIELDS,
                ),
                "",
                chapter("Mapping", "For `firstlap map --set NAME=VALUE`.", MAP_FIELDS),
                "",
                chapter("Localization", "For `firstlap localize --set NAME=VALUE`.", LOCALIZER_FIELDS),
                "",
                chapter(
                    "Tuning", "How `firstlap tune` evaluates candidates (`--judge NAME=VALUE`).", EVALUATION_FIELDS
                ),
                "",
                *ros_chapters(),
            ]
        )
        + "\n"
    )


def entries(title: str, text: str, rows: tuple[Entry, ...]) -> str:
    """Parameters of a node that are not fields of a struct."""
    lines = ["| name | default | range | description |", "|---|---|---|---|"]
    for row in rows:
        allowed = "" if row.min is None or row.max is None else f"{row.min:g} to {row.max:g}"
        default = str(row.default).lower() if isinstance(row.default, bool) else row.default
        lines.append(f"| `{row.name}` | {default} | {allowed} | {row.doc}{'; read at startup' * row.fixed} |")
    return f"## {title}\n\n{text}\n\n" + "\n".join(lines)


def ros_chapters() -> list[str]:
    """Parameters of the ROS 2 nodes other than those of the driver."""
    return [
        entries("The node `firstlap drive`", "ROS parameters, in addition to those of the driver's setup.", DRIVE),
        "",
        chapter(
            "State estimation of `firstlap drive`",
            "Used with `state_estimate.enabled`; the car is that of the setup (`car.*`). See "
            "[estimation.md](estimation.md).",
            FieldTable(_core.StateEstimateParams.fields()),
        ),
        "",
        entries("The node `firstlap sim`", "ROS parameters.", SIM),
        "",
        entries("Simulated faults of `firstlap sim`", "They can be changed at run time.", FAULTS),
        "",
        chapter("World of `firstlap sim`", "Read at startup.", FieldTable(_core.WorldOptions.fields())),
    ]


def column_table(columns: list[dict[str, str]]) -> str:
    """One Markdown table of what is given out."""
    lines = ["| name | unit | description |", "|---|---|---|"]
    lines += [f"| `{column['name']}` | {column['unit']} | {column['doc'].replace('|', '/')} |" for column in columns]
    return "\n".join(lines)


def results() -> str:
    """docs/results-format.md"""
    tables = _core.result_tables()
    parts = [RESULTS_HEAD.rstrip()]
    for title, text, names in RESULTS:
        parts.append(f"## {title}\n\n{text}")
        parts += [f"### {name}\n\n{column_table(tables.pop(name))}" for name in names]
    if tables:
        raise SystemExit(f"no chapter of docs/results-format.md lists {', '.join(tables)}")
    return "\n\n".join(parts) + "\n"


def stub() -> str:
    """python/firstlap/_core.pyi"""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "_core.pyi"
        command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "firstlap._core", "-o", str(output)]
        subprocess.run(command, check=True)
        return output.read_text(encoding="utf-8")


def main() -> int:
    """Writes or, with --check, compares. Exit code 1 if a file is out of date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    stale = 0
    for path, text in (
        (ROOT / "docs/parameters.md", parameters()),
        (ROOT / "docs/results-format.md", results()),
        (ROOT / "python/firstlap/_core.pyi", stub()),
    ):
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            continue
        if check:
            print(f"{path.relative_to(ROOT)} is out of date: make docs", file=sys.stderr)
            stale = 1
        else:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
    return stale


if __name__ == "__main__":
    sys.exit(main())
