"""firstlap tracks"""

from __future__ import annotations

from typing import Any

from rich.table import Table

from firstlap.cli.common import JsonOption, console, print_json
from firstlap.tracks.library import list_tracks, load_track


def tracks(as_json: JsonOption = False) -> int:
    """List our tracks with length and widths."""
    rows: list[dict[str, Any]] = []
    for name in list_tracks():
        track = load_track(name)
        low, median, high = track.width_summary()
        rows.append({"track": name, "length": track.length, "width": {"min": low, "median": median, "max": high}})
    if as_json:
        print_json({"tracks": rows})
        return 0
    table = Table()
    table.add_column("track")
    for heading in ("length m", "width m, min", "median", "max"):
        table.add_column(heading, justify="right")
    for row in rows:
        widths = row["width"]
        table.add_row(row["track"], f"{row['length']:.1f}", *(f"{widths[key]:.2f}" for key in ("min", "median", "max")))
    console().print(table)
    return 0
