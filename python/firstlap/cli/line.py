"""firstlap line"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, TextColumn

from firstlap.cli.common import CarOption, JsonOption, check_outputs, console, draw, note, print_json, progress_bar

if TYPE_CHECKING:
    from firstlap.config.car_file import Car
    from firstlap.planning.raceline.line import RaceLine
    from firstlap.planning.raceline.params import LineParams
    from firstlap.tracks.track import Track

TrackArgument = Annotated[
    str,
    typer.Argument(metavar="MAP", help="A ROS map YAML, name of a track, a track file, or random:SEED."),
]
OutputOption = Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Output file (.csv).")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot the line with its speeds.")]
MuOption = Annotated[float | None, typer.Option("--mu", help="Friction used for planning; default: the car's.")]
MarginOption = Annotated[float | None, typer.Option("--margin", help="Minimum clearance to walls [m].")]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Change one parameter of the line, see docs/parameters.md; repeatable."
    ),
]
ReverseOption = Annotated[bool, typer.Option("--reverse", help="Compute the line for the opposite direction.")]


def line(
    track: TrackArgument,
    output: OutputOption,
    plot: PlotOption = None,
    car: CarOption = "default",
    mu: MuOption = None,
    margin: MarginOption = None,
    changes: ChangesOption = None,
    reverse: ReverseOption = False,
    as_json: JsonOption = False,
) -> int:
    """Compute the minimum-time racing line of a car on a map, with its speeds."""
    from firstlap.common.files import check_writable
    from firstlap.config.car_file import load_car
    from firstlap.config.table import check_values, from_values
    from firstlap.planning.raceline.corridor import Corridor
    from firstlap.planning.raceline.line_file import SUFFIXES, write_line
    from firstlap.planning.raceline.params import LINE_FIELDS, LineParams
    from firstlap.planning.raceline.plot import plot_line
    from firstlap.tracks.library import load_track

    check_writable(output, SUFFIXES)
    check_outputs(plot)
    assigned = _assigned(changes, {"mu": mu, "margin": margin})
    params = from_values(LineParams, "line", check_values(LINE_FIELDS, dict(assigned), "firstlap line"))
    loaded_car, loaded = load_car(car), load_track(track)
    loaded = loaded.reversed() if reverse else loaded
    found = _compute(loaded, loaded_car, params)
    write_line(found, output)
    clearance = float(Corridor(loaded, loaded_car).clearance(found.path.poses).min())
    summary = {
        "track": loaded.name,
        "car": loaded_car.name,
        "set": assigned,
        "length": found.length,
        "lap_time": found.lap_time,
        "min_clearance": clearance,
        "notes": [*loaded.notes, *found.notes],
    }
    if as_json:
        print_json(summary)
    else:
        _print(summary, found, output)
    draw(plot, lambda path: plot_line(found, loaded, path), as_json)
    return 0


def _assigned(changes: list[str] | None, named: dict[str, float | None]) -> dict[str, Any]:
    """The parameters of --set, and those that have an option of their own. Raises InputError."""
    from firstlap.planning.raceline.params import LINE_FIELDS

    values = dict(LINE_FIELDS.parse_assignment(text) for text in changes or [])
    assigned = {entry.key: value for entry, value in values.items()}
    return assigned | {f"line.{name}": value for name, value in named.items() if value is not None}


def _compute(track: Track, car: Car, params: LineParams) -> RaceLine:
    from firstlap.planning.raceline.line import make_line

    with progress_bar(TextColumn("{task.description}"), BarColumn(50)) as bar:
        task = bar.add_task("line", total=1.0)

        def tell(what: str, share: float) -> None:
            bar.update(task, description=f"minimum {what}", completed=share)

        return make_line(track, car, params, tell)


def _print(summary: dict[str, Any], line: RaceLine, output: Path) -> None:
    for remark in summary["notes"]:
        note(remark)
    out = console()
    out.print(
        f"{escape(summary['track'])}: lap {line.lap_time:.2f} s on a line of {line.length:.1f} m, "
        f"{line.speed.min():.1f} to {line.speed.max():.1f} m/s, at least {summary['min_clearance']:.2f} m from the "
        "walls",
        soft_wrap=True,
    )
    out.print(escape(f"line: {output}"), soft_wrap=True)
