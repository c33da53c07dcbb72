"""The report of a comparison, in Markdown or HTML: table, plot, and everything needed to reproduce it."""

from __future__ import annotations

import base64
import html
import io
import os
import platform
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from firstlap.common.cache import code_hash
from firstlap.common.files import check_writable, write_together
from firstlap.common.version import __version__
from firstlap.config.car_file import CAR_FIELDS
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import LOCAL, TUNED_FOR
from firstlap.evaluation.compare.compare import Comparison, stamp
from firstlap.evaluation.compare.plot import comparison_figure
from firstlap.evaluation.published import LAST
from firstlap.tracks.track_hash import track_hash

REPORTS = (".md", ".html")
DPI = 110
"""Suffix of the plot."""
HEADINGS = (
    "driver", "tuned for", "map", "prep. s", "finished", "best s", "median s", "spread", "mean m/s", "distance m",
    "clear. m", "p50 µs", "p99 µs", "skipped", "relative",
)  # fmt: skip
LEGEND = (
    "tuned for: the tracks on which a search found the setup; a tuned driver is no fair opponent of an untuned one. "
    "Laps are the flying laps of finished races; spread is their standard deviation and distance their mean length. "
    "p50 and p99 are CPU times of a step. skipped counts scans that arrived while the driver was computing and were "
    "skipped. relative is the median lap relative to that of `REFERENCE`."
)
STYLE = """body { font: 15px/1.5 system-ui, sans-serif; color: #22272e; max-width: 75rem; margin: 2rem auto }
table { border-collapse: collapse }
td, th { padding: .25rem .6rem; border-bottom: 1px solid #d5dade; text-align: right }
td:first-child, th:first-child { text-align: left } pre { background: #f4f6f8; padding: .8rem; overflow-x: auto }
img { max-width: 100% }"""


def number(value: float | None, digits: int = 2) -> str:
    """The number as text, or a dash for None."""
    return "–" if value is None else f"{value:.{digits}f}"


def table_rows(found: dict[str, Any]) -> list[list[str]]:
    """The rows of the table as text, in the order of `HEADINGS`."""
    return [
        [
            row["label"],
            row["tuned_for"] or "untuned",
            "yes" if row["needs_map"] else "no",
            number(row["preparation"], 1) if row["needs_map"] else "–",
            f"{row['finished']} of {row['runs']}",
            number(row["best"]),
            number(row["median"]),
            number(row["spread"], 3),
            number(row["mean_speed"]),
            number(row["distance"]),
            number(row["min_clearance"]),
            number(row["compute_p50"], 0),
            number(row["compute_p99"], 0),
            str(row["skipped_scans"]),
            number(row["relative"], 3),
        ]
        for row in found["entries"]
    ]


def order_lines(found: dict[str, Any]) -> list[str]:
    """Our ranking and the paper's, one sentence each: for the paper's setting, then for the fastest setups."""
    lines = _gap_lines("the paper's setting", found["published"])
    missing = [row for row in found["entries"] if (row["driver"], row["setup"]) == (LOCAL, LAST)]
    if missing and "local" not in found["published"]["laps"]:
        row = missing[0]
        lines.append(f"the paper's setting ({row['label']}): {row['finished']} of {row['runs']} races finished")
    return lines + _gap_lines("the fastest setups", found["order"])


def _gap_lines(title: str, order: dict[str, Any]) -> list[str]:
    lines = []
    for slower, faster in (("reactive", "local"), ("local", "global")):
        gap = order["gaps"][f"{slower}_to_{faster}"]
        if gap["ours"] is not None:
            ours = f"{slower} ({_said(order['laps'][slower])}) compared with {faster} ({_said(order['laps'][faster])})"
            lines.append(f"{title}: {ours}: {gap['ours']:+.1%} per lap; in the paper {gap['paper']:+.1%}")
    return lines


def _said(lap: dict[str, Any]) -> str:
    return f"{lap['label']}, {tuning_text(lap)}, {lap['median']:.2f} s"


def tuning_text(row: dict[str, Any]) -> str:
    """Whether the setup of a row was tuned, and for what."""
    return f"tuned for {row['tuned_for']}" if row["tuned_for"] else "untuned"


def write_report(comparison: Comparison, path: str | Path, command: str) -> None:
    """Writes the report; a Markdown report writes its plot next to itself. Raises InputError."""
    path = check_writable(path, REPORTS)
    picture = io.BytesIO()
    comparison_figure(comparison).savefig(picture, format="png", dpi=DPI)
    if path.suffix.lower() == ".html":
        source = "data:image/png;base64," + base64.b64encode(picture.getvalue()).decode()
        write_together({path: _as_html(comparison, _markdown(comparison, command), source).encode()})
        return
    beside = check_writable(path.with_suffix(".png"), (".png",))
    text = _markdown(comparison, command).replace("PICTURE", f"![lines, laps and speeds]({beside.name})")
    write_together({beside: picture.getvalue(), path: text.encode()})


def _as_html(comparison: Comparison, markdown: str, picture: str) -> str:
    from markdown_it import MarkdownIt  # comes with rich

    body = MarkdownIt("commonmark").enable("table").render(markdown)
    image = f'<img src="{picture}" alt="lines, laps and speeds">'
    title = html.escape(f"firstlap compare {comparison.track.name}")
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>\n{STYLE}\n</style></head>\n<body>\n{body.replace('PICTURE', image)}</body></html>\n"
    )


def _cells(cells: list[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def _markdown(comparison: Comparison, command: str) -> str:
    found = comparison.to_dict()
    name = Path(comparison.track.name).name
    conditions = "".join(f", {option} {value:g}" for option, value in comparison.options.items())
    lines = [
        f"# {name}: {len(comparison.entries)} drivers compared",
        f"{comparison.track.length:.1f} m, car {comparison.car.name}, {comparison.laps} laps from a standing start, "
        f"seeds 1 to {comparison.seeds}, latency {comparison.latency}{conditions}.",
        LEGEND.replace("REFERENCE", str(found["reference"])),
        "\n".join([_cells(list(HEADINGS)), "|" + "---|" * len(HEADINGS), *map(_cells, table_rows(found))]),
        "\n".join(f"- {line}." for line in order_lines(found)),
        "PICTURE",
        "## All races",
        _races(comparison),
        "## How to reproduce",
        f"```sh\n{command}\n```",
        _versions(comparison),
        *_setups(comparison),
        _car(comparison),
    ]
    return "\n\n".join(line for line in lines if line) + "\n"


def _races(comparison: Comparison) -> str:
    rows = ["| driver | seed | outcome | laps s | time s | distance m |", "|---|---|---|---|---|---|"]
    for entry in comparison.entries:
        for record in entry.records:
            laps = ", ".join(f"{lap.time:.3f}" for lap in record.laps) or "–"
            rows.append(
                _cells([entry.label, str(record.seed), record.outcome, laps, number(record.time),
                        number(record.distance)])
            )  # fmt: skip
    return "\n".join(rows)


def _versions(comparison: Comparison) -> str:
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"
    rows = {
        "written": stamp(),
        "firstlap": f"{__version__}, core {code_hash(False)}",
        "Python, numpy": f"{platform.python_version()}, {np.__version__}",
        "machine": f"{machine}, {comparison.jobs} parallel races",
        "track": f"{comparison.track.name}, content hash {track_hash(comparison.track)}",
        "car": comparison.car.name,
    }
    return "\n".join(["| | |", "|---|---|", *(_cells([name, value]) for name, value in rows.items())])


def _setups(comparison: Comparison) -> list[str]:
    """Each setup as a file that `--setup` reads."""
    parts = []
    for entry in comparison.entries:
        sections: dict[str, Any] = {"driver": entry.setup.driver}
        if entry.setup.tuned_for:
            sections[TUNED_FOR] = entry.setup.tuned_for
        for (section, field), value in entry.setup.given.items():
            sections.setdefault(section, {})[field] = value
        text = yaml.safe_dump(sections, sort_keys=False, allow_unicode=True)
        title = driver_kind(entry.setup.driver).title
        parts.append(f"### {entry.label} ({title})\n\n```yaml\n{text}```")
    return parts


def _car(comparison: Comparison) -> str:
    """What differs from the default car."""
    values = comparison.car.core.values()
    sections: dict[str, dict[str, Any]] = {}
    for field in CAR_FIELDS.fields:
        if values[field.section][field.name] != field.default:
            sections.setdefault(field.section, {})[field.name] = values[field.section][field.name]
    if not sections:
        return "The car is the default car, with the values of docs/parameters.md."
    return f"### Car {comparison.car.name}\n\n```yaml\n{yaml.safe_dump(sections, sort_keys=False)}```"
