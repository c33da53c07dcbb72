"""Writes the generated pages: docs/parameters.md and the types of the extension. With --check: compares only."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from firstlap import _core
from firstlap.car_file import CAR_FIELDS
from firstlap.drivers import DRIVERS, DriverKind
from firstlap.localisation.localiser import LOCALISER_FIELDS
from firstlap.mapping.parameters import MAP_FIELDS
from firstlap.mpc.params import MPC_FIELDS
from firstlap.parameters import Field, FieldTable
from firstlap.race import OPTION_FIELDS
from firstlap.raceline.params import LINE_FIELDS
from firstlap.ros.names import DRIVE, FAULTS, SIM, Entry
from firstlap.tuning.spread import JUDGE_FIELDS

ROOT = Path(__file__).resolve().parents[1]
HEAD = """<!-- Written by `make docs` from the field tables. Do not edit. -->

# Parameters

A default stands in one place, its C++ struct or, for what only Python has, its Python table; this page, the readers of
the YAML files, the bindings and the checks loop over those tables.
"""


def table(fields: list[Field]) -> str:
    """One Markdown table."""
    lines = ["| name | default | range | unit | what |", "|---|---|---|---|---|"]
    for field in fields:
        default = str(field.default).lower() if field.type == "bool" else f"{field.default:g}"
        allowed = "true, false" if field.type == "bool" else f"{field.min:g} to {field.max:g}"
        unit = field.unit.replace("^2", "²")
        lines.append(f"| `{field.name}` | {default} | {allowed} | {unit} | {field.doc.replace('|', '/')} |")
    return "\n".join(lines)


def chapter(title: str, text: str, fields: FieldTable) -> str:
    """One kind of file."""
    parts = [f"## {title}\n\n{text}"]
    for section in fields.sections:
        rows = [field for field in fields.fields if field.section == section]
        parts += [f"### {section}\n\n{table(rows)}"]
    return "\n\n".join(parts)


def driver_chapter(kind: DriverKind) -> str:
    """The setups of one driver."""
    first = "" if kind.name == "local" else f" It begins with the line `driver: {kind.name}`."
    names = "Any of these names also works with `--set NAME=VALUE`."
    text = f"Sections of a setup file (`--setup FILE`) of the driver `{kind.name}`, {kind.title}.{first} {names}"
    if kind.name == "global":
        text += (
            " Its sections are `guard`, those of lines (`line`) and of predictive control (`mpc`), and those of mapping"
            " and localisation, whose names begin with `map_` and `pose_` here: `map_drive`, `pose_filter`. Their rows"
            " stand in the chapters further down."
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
                    "Sections of a car file (`--car FILE`). What it leaves out is the default car's, as listed.",
                    CAR_FIELDS,
                ),
                "",
                chapter(
                    "Lines", "Of `firstlap line --set NAME=VALUE`, see [the racing line](racing-line.md).", LINE_FIELDS
                ),
                "",
                chapter("Predictive control", "Of the controller that follows a line.", MPC_FIELDS),
                "",
                chapter("Races", "Options of `firstlap.race(..., options={...})`.", OPTION_FIELDS),
                "",
                chapter("Mapping", "Names of `firstlap map --set NAME=VALUE`.", MAP_FIELDS),
                "",
                chapter("Localisation", "Names of `firstlap localise --set NAME=VALUE`.", LOCALISER_FIELDS),
                "",
                chapter("Tuning", "How `firstlap tune` judges candidates (`--judge NAME=VALUE`).", JUDGE_FIELDS),
                "",
                *ros_chapters(),
            ]
        )
        + "\n"
    )


def entries(title: str, text: str, rows: tuple[Entry, ...]) -> str:
    """Parameters of a node that are no numbers of a struct."""
    lines = ["| name | default | range | what |", "|---|---|---|---|"]
    for row in rows:
        allowed = "" if row.min is None or row.max is None else f"{row.min:g} to {row.max:g}"
        default = str(row.default).lower() if isinstance(row.default, bool) else row.default
        lines.append(f"| `{row.name}` | {default} | {allowed} | {row.doc}{'; read at the start' * row.fixed} |")
    return f"## {title}\n\n{text}\n\n" + "\n".join(lines)


def ros_chapters() -> list[str]:
    """What the ROS 2 nodes have beside the parameters of the driver."""
    return [
        entries("The node `firstlap drive`", "ROS parameters, beside those of the driver's setup.", DRIVE),
        "",
        chapter("Its state estimate", "With `fuse_state`.", FieldTable(_core.StateEstimateParams.fields())),
        "",
        entries("The node `firstlap sim`", "ROS parameters.", SIM),
        "",
        entries("Its faults", "They can be changed while it runs.", FAULTS),
        "",
        chapter("Its world", "Read at the start.", FieldTable(_core.WorldOptions.fields())),
    ]


def stub() -> str:
    """python/firstlap/_core.pyi"""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "_core.pyi"
        command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "firstlap._core", "-o", str(output)]
        subprocess.run(command, check=True)
        return output.read_text(encoding="utf-8")


def main() -> int:
    """Writes or, with --check, compares; 1 where a page is out of date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    stale = 0
    for path, text in (
        (ROOT / "docs/parameters.md", parameters()),
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
