"""firstlap line"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, TextColumn

from firstlap.cli.common import CarOption, JsonOption, console, draw, note, print_json, progress_bar


def line(
    track: Annotated[
        str,
        typer.Argument(metavar="MAP", help="A ROS map YAML, name of a track, a track file, or random:SEED."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Output file (.csv).")],
    plot: Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot the line with its speeds.")] = None,
    car: CarOption = "default",
    mu: Annotated[float | None, typer.Option("--mu", help="Friction used for planning; default: the car's.")] = None,
    margin: Annotated[float | None, typer.Option("--margin", help="Minimum clearance to walls [m].")] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="Change one parameter of the line, see docs/parameters.md; repeatable."
        ),
    ] = None,
    reverse: Annotated[bool, typer.Option("--reverse", help="Compute the line for the opposite direction.")] = False,
    as_json: JsonOption = False,
) -> int:
    """Compute the minimum-time racing line of a car on a map, with its speeds."""
    from firstlap.common.files import check_writable
    from firstlap.config.car_file import load_car
    from firstlap.config.table import check_values, from_values
    from firstlap.planning.raceline.corridor import Corridor
    from firstlap.planning.raceline.line import make_line
    from firstlap.planning.raceline.line_file import SUFFIXES, write_line
    from firstlap.planning.raceline.params import LINE_FIELDS, LineParams
    from firstlap.planning.raceline.plot import plot_line
    from firstlap.plots.primitives import PICTURE_SUFFIXES
    from firstlap.tracks.library import load_track

    check_writable(output, SUFFIXES)
    if plot:
        check_writable(plot, PICTURE_SUFFIXES)
    values = dict(LINE_FIELDS.parse_assignment(text) for text in changes or [])
    assigned = {entry.key: value for entry, value in values.items()}
    named = {"mu": mu, "margin": margin}
    assigned |= {f"line.{name}": value for name, value in named.items() if value is not None}
    params = from_values(LineParams, "line", check_values(LINE_FIELDS, dict(assigned), "firstlap line"))
    loaded_car, loaded = load_car(car), load_track(track)
    loaded = loaded.reversed() if reverse else loaded
    with progress_bar(TextColumn("{task.description}"), BarColumn(50)) as bar:
        task = bar.add_task("line", total=1.0)
        found = make_line(
            loaded,
            loaded_car,
            params,
            lambda what, share: bar.update(task, description=f"minimum {what}", completed=share),
        )
    write_line(found, output)
    clearance = float(Corridor(loaded, loaded_car).clearance(found.path.poses).min())
    if as_json:
        print_json(
            {
                "track": loaded.name,
                "car": loaded_car.name,
                "set": assigned,
                "length": found.length,
                "lap_time": found.lap_time,
                "min_clearance": clearance,
                "notes": [*loaded.notes, *found.notes],
            }
        )
        draw(plot, lambda path: plot_line(found, loaded, path), as_json)
        return 0
    for remark in [*loaded.notes, *found.notes]:
        note(remark)
    out = console()
    out.print(
        f"{escape(loaded.name)}: lap {found.lap_time:.2f} s on a line of {found.length:.1f} m, "
        f"{found.speed.min():.1f} to {found.speed.max():.1f} m/s, at least {clearance:.2f} m from the walls",
        soft_wrap=True,
    )
    out.print(escape(f"line: {output}"), soft_wrap=True)
    draw(plot, lambda path: plot_line(found, loaded, path), as_json)
    return 0
