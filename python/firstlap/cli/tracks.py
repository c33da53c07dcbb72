"""firstlap tracks"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.table import Table

from firstlap.cli.common import JsonOption, console, print_json
from firstlap.tracks.library import list_tracks, load_track


def tracks(
    named: Annotated[
        list[str] | None, typer.Argument(metavar="TRACK", help="Tracks as for `race`; default: all our tracks.")
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """List tracks with length, widths, and remarks on maps."""
    rows: list[dict[str, Any]] = []
    for name in named or list_tracks():
        track = load_track(name)
        low, median, high = track.width_summary()
        widths = {"min": low, "median": median, "max": high}
        rows.append({"track": name, "length": track.length, "width": widths, "notes": list(track.notes)})
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
    for row in rows if named else ():
        for note in row["notes"]:
            console().print(f"{row['track']}: {note}", markup=False)
    return 0
