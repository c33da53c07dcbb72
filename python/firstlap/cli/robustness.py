"""firstlap robustness"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from firstlap.cli.common import (
    BothOption,
    CarOption,
    ConditionOption,
    JsonOption,
    LapsOption,
    LidarOption,
    SetOption,
    SetupOption,
    check_outputs,
    chosen_car,
    chosen_options,
    chosen_setup,
    console,
    counting_bar,
    described_options,
    draw,
    fail,
    note,
    print_json,
)
from firstlap.cli.survey import expand
from firstlap.common.version import __version__
from firstlap.evaluation.robustness.cases import BESIDE, SWEEPS, Case, Drive, Robustness, chosen_sweeps
from firstlap.tracks.library import load_track

TracksArgument = Annotated[list[str], typer.Argument(metavar="TRACK", help="Tracks as for `survey`.")]
SweepsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--sweep", metavar="NAME", help=f"Run only this sweep: {', '.join(s.name for s in SWEEPS)}; repeatable."
    ),
]
SeedsOption = Annotated[int, typer.Option("--seeds", min=1, max=1_000, help="Races per case, seeds 1 to K.")]
PlacesOption = Annotated[
    int, typer.Option("--places", min=1, max=1_000, help="Obstacle positions per lap, on the line and beside it.")
]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Plot the curves.")]


def robustness(
    tracks: TracksArgument,
    setup: SetupOption = None,
    changes: SetOption = None,
    sweeps: SweepsOption = None,
    laps: LapsOption = 2,
    seeds: SeedsOption = 2,
    both: BothOption = False,
    places: PlacesOption = 8,
    car: CarOption = "default",
    lidar: LidarOption = None,
    options: ConditionOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> int:
    """Race with lost beams, noise, joints, slow scans, latency, speed, LiDAR and servo errors, and sudden obstacles.
    Exit code 0 without contact, 1 otherwise."""
    check_outputs(plot)
    chosen = chosen_sweeps(sweeps)
    the_car = chosen_car(car, lidar)
    races = Robustness(chosen_setup(setup, changes), the_car, laps, chosen_options(options, the_car))
    loaded = {spec: load_track(spec) for spec in expand(tracks)}
    interrupted = _drive(races, lambda: races.cases(chosen, loaded, seeds, both, places))
    found = {
        "version": __version__,
        **races.to_dict(),
        "seeds": seeds,
        "both": both,
        "places": places,
        "beside": list(BESIDE),
        "interrupted": interrupted,
    }
    if as_json:
        print_json(found)
    else:
        _print(found)
    if found["sweeps"]:
        from firstlap.evaluation.robustness.plot import plot_robustness

        draw(plot, lambda path: plot_robustness(found, path), as_json)
    clean = all(drive.contact_free for drive in races.drives)
    return fail(f"interrupted after {len(races.drives)} races", 130) if interrupted else int(not clean)


def _drive(races: Robustness, cases: Callable[[], Iterable[Case]]) -> bool:
    """Plans and drives the races; returns whether they were interrupted."""
    contacts = 0
    with counting_bar() as bar:
        task = bar.add_task("planning", total=None)

        def done(drive: Drive) -> None:
            nonlocal contacts
            contacts += not drive.contact_free
            bar.update(task, advance=1, description=f"racing, {contacts} with contact")

        try:
            planned = list(cases())
            bar.update(task, total=len(planned))
            races.drive(planned, done)
        except KeyboardInterrupt:
            return True
    return False


def _print(found: dict[str, Any]) -> None:
    out = console()
    conditions = described_options(found["options"])
    for sweep in found["sweeps"]:
        box = sweep["name"] == "obstacle"
        table = Table(title=escape(f"{sweep['title']}, setup {found['setup']}{conditions}"))
        last = ("passed %", "stopped %", "impossible") if box else ("lap / undisturbed",)
        for heading in (f"{sweep['unit'] or 'times'}", "runs", "contact-free %", "finished %", *last):
            table.add_column(heading, justify="right")
        for point in sweep["points"]:
            clean = point["contact_free"] == 1.0
            rates = [_percent(point["contact_free"]), _percent(point["finished"])]
            if box:
                rest = [_percent(point["passed"]), _percent(point["stopped"]), str(point["impossible"])]
            else:
                rest = ["-" if point["lap_ratio"] is None else f"{point['lap_ratio']:.3f}"]
            style = "" if clean else "yellow"
            table.add_row(f"{point['value']:g}", str(point["runs"]), *rates, *rest, style=style)
        out.print(table)
    for remark in found["notes"]:
        note(remark)


def _percent(rate: float | None) -> str:
    return "-" if rate is None else f"{100.0 * rate:.1f}"
