"""firstlap tracks"""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.table import Table

from firstlap.cli.common import CarOption, JsonOption, console, print_json, refuse
from firstlap.config.car_file import Car, load_car
from firstlap.sim.drivable import DEFAULT_MARGIN, Drivable, drivable, search_lap, turning_radius
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

DIRECTIONS = ("forward", "opposite")
MarginOption = Annotated[
    float | None,
    typer.Option("--margin", min=0.0, max=1.0, metavar="M", help="With --drivable: safety distance around the car."),
]


def tracks(
    named: Annotated[
        list[str] | None, typer.Argument(metavar="TRACK", help="Tracks as for `race`; default: all our tracks.")
    ] = None,
    search: Annotated[
        bool, typer.Option("--drivable", help="Search for a lap that the car can drive without reverse, both ways.")
    ] = False,
    margin: MarginOption = None,
    car: CarOption = "default",
    as_json: JsonOption = False,
) -> int:
    """List tracks with length, widths, and remarks on maps; say where a corner is tighter than the car's turning
    circle."""
    if not search:
        refuse({"--margin": margin}, "without --drivable")
    chosen, rows = load_car(car), []
    for name in named or list_tracks():
        track = load_track(name)
        row = _measured(name, track)
        if search:
            row["drivable"] = _searched(track, chosen, DEFAULT_MARGIN if margin is None else margin)
        elif named:
            row["notes"] += _too_tight(track, chosen)
        rows.append(row)
    if as_json:
        print_json({"car": chosen.name, "tracks": rows} if search else {"tracks": rows})
        return 0
    console().print(_search_table(rows, chosen) if search else _table(rows))
    for row in rows if named or search else ():
        for text in [*row["notes"], *(_sentence(found) for found in row.get("drivable", ()) if not found["drivable"])]:
            console().print(f"{row['track']}: {text}", markup=False, soft_wrap=True)
    return 0


def _measured(name: str, track: Track) -> dict[str, Any]:
    low, median, high = track.width_summary()
    widths = {"min": low, "median": median, "max": high}
    return {"track": name, "length": track.length, "width": widths, "notes": list(track.notes)}


def _directions(track: Track) -> list[tuple[str, Track]]:
    return list(zip(DIRECTIONS, (track, track.reversed()), strict=True))


def _searched(track: Track, car: Car, margin: float) -> list[dict[str, Any]]:
    return [_as_dict(direction, drivable(way, car, margin)) for direction, way in _directions(track)]


def _as_dict(direction: str, found: Drivable) -> dict[str, Any]:
    """The answer for one direction; drivable is None if the search did not decide."""
    return {
        "direction": direction,
        "drivable": None if found.search.verdict == "undecided" else found.search.drivable,
        "margin": found.margin,
        "largest_margin": found.largest_margin,
        "turning_radius": found.turning_radius,
        "largest_radius": found.largest_radius,
        "traveled": found.search.traveled,
        "blocked_at": None if found.blocked_at is None else asdict(found.blocked_at),
        "corner": None if found.corner is None else asdict(found.corner),
    }


def _too_tight(track: Track, car: Car) -> list[str]:
    """A remark for each direction without a lap that the car can drive."""
    ways = [direction for direction, way in _directions(track) if not search_lap(way, car).drivable]
    return [
        f"{direction}: no lap found for a car that turns with {turning_radius(car):.2f} m; --drivable says where"
        for direction in ways
    ]


def _sentence(found: dict[str, Any]) -> str:
    place, corner, needed = found["blocked_at"], found["corner"], found["largest_radius"]
    verdict = "undecided, too many states" if found["drivable"] is None else "not drivable"
    radius = "no turning radius" if needed is None else f"a turning radius of up to {needed:.2f} m"
    return (
        f"{found['direction']}: {verdict}; the search gets to ({place['x']:.2f}, {place['y']:.2f}), "
        f"{found['traveled']:.1f} m from the start; the tightest curve there is at {corner['s']:.1f} m, "
        f"({corner['x']:.2f}, {corner['y']:.2f}): radius {corner['radius']:.2f} m, width {corner['width']:.2f} m; "
        f"the car turns with {found['turning_radius']:.2f} m, and {radius} would do"
    )


def _table(rows: list[dict[str, Any]]) -> Table:
    table = Table()
    table.add_column("track")
    for heading in ("length m", "width m, min", "median", "max"):
        table.add_column(heading, justify="right")
    for row in rows:
        widths = row["width"]
        table.add_row(row["track"], f"{row['length']:.1f}", *(f"{widths[key]:.2f}" for key in ("min", "median", "max")))
    return table


def _search_table(rows: list[dict[str, Any]], car: Car) -> Table:
    table = Table(title=f"car {car.name}, which turns with {turning_radius(car):.2f} m")
    for heading in ("track", "direction", "drivable"):
        table.add_column(heading)
    for heading in ("up to a margin of m", "up to a turning radius of m"):
        table.add_column(heading, justify="right")
    verdicts = {True: "[green]yes[/]", False: "[red]no[/]", None: "[yellow]undecided[/]"}
    for row in rows:
        for found in row["drivable"]:
            limits = (found["largest_margin"], found["largest_radius"])
            shown = ("–" if limit is None else f"{limit:.2f}" for limit in limits)
            table.add_row(row["track"], found["direction"], verdicts[found["drivable"]], *shown)
    return table
