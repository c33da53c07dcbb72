"""`firstlap replay --map`: compares the perception of a recording with a map of its track."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import console
from firstlap.cli.recording import scan_progress, scans_bar
from firstlap.common.errors import InputError
from firstlap.common.text import UNKNOWN, counted, short_name
from firstlap.config.car_file import Car
from firstlap.config.setup_file import LOCAL, Setup

if TYPE_CHECKING:
    from firstlap.evaluation.perception.map_comparison import MapComparison
    from firstlap.recordings.recording import Recording


def compare_with_map(recording: Recording, setup: Setup, car: Car, map_path: Path, mask_body: bool) -> MapComparison:
    """Compares the setup's perception of `recording` with the map, with a progress bar. Raises InputError."""
    from firstlap.evaluation.perception.map_comparison import measure

    if setup.driver != LOCAL:
        raise InputError(f"--map: driver {setup.driver} has no centerline to compare with a map; expected local")
    with scans_bar() as bar:
        on_progress = scan_progress(bar, "measuring", len(recording))
        return measure(recording, setup, car, map_path, mask_body=mask_body, on_progress=on_progress)


def print_against_map(found: dict[str, Any]) -> None:
    """Prints the table of docs/perception.md for one recording."""
    table = Table(
        title=escape(
            f"compared with {short_name(found['map'])}: {found['metres']:.0f} m, {counted(found['turns'], 'turn')}"
        )
    )
    table.add_column("")
    for ahead in found["error"]:
        table.add_column(f"{ahead} m ahead", justify="right")
    for label, key in (("centerline error", "error"), ("path error", "path_error"), ("width error", "width_error")):
        cells = [_pair(found[key][ahead]) for ahead in found[key]]
        table.add_row(f"{label}: median, 95 % [m]", *cells)
    console().print(table)
    shares = {
        "no line": found["no_line"],
        "bad": found["bad"],
        "precision": found["precision"],
        "recall": found["recall"],
        "not evaluated": found["not_judged"],
    }
    console().print(", ".join(f"{name} {_percent(value)}" for name, value in shares.items()), soft_wrap=True)


def _pair(error: dict[str, Any]) -> str:
    return UNKNOWN if error["median"] is None else f"{error['median']:.3f}, {error['p95']:.3f}"


def _percent(value: float | None) -> str:
    return UNKNOWN if value is None else f"{100.0 * value:.1f} %"
