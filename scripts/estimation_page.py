"""Write docs/estimation.md with its tables and plots, from races with and without the state estimate.

Usage: scripts/estimation_page.py FOLDER
"""

import pathlib
import sys
from typing import Any

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.estimation.cases import CASES
from firstlap.evaluation.estimation.drive import Drive, drive, errors
from firstlap.evaluation.estimation.plot import plot_drive
from firstlap.tracks.library import load_track

TRACKS = ("arena", "corners", "hairpins", "oval")
SETUPS = ("sure", "brisk")
LAPS, SEED = 2, 1
DRAWN = ("arena", "sure")
PICTURES = {"slip": "estimation_slip.png", "lock": "estimation_lock.png", "bias": "estimation_bias.png"}

HEAD = pathlib.Path(__file__).with_suffix(".md")
"""The hand-written part of the page."""

CASE_LIST = """
The cases: {cases}.
"""


def drives_of(setup_name: str, estimated: bool = True) -> dict[str, list[Drive]]:
    """The drives of each case on all tracks."""
    setup, car = load_setup(setup_name), load_car("default")
    tracks = [load_track(name) for name in TRACKS]
    return {
        case.name: [drive(track, setup, car, case, laps=LAPS, seed=SEED, estimated=estimated) for track in tracks]
        for case in CASES
    }


def pair(found: dict[str, Any]) -> str:
    """Measured and estimated."""
    return "-" if found["raw"] is None else f"{found['raw']:.3f} → {found['estimate']:.3f}"


def error_table(drives: dict[str, list[Drive]]) -> str:
    """One row per case."""
    lines = [
        "| case | speed m/s | locked m/s | no accelerometer m/s | yaw rate rad/s | gyro bias rad/s | slip %/(m/s²) | "
        "side slip m/s |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, runs in drives.items():
        row = errors(runs)
        slip = 100.0 * (row["wheel_slip"]["error"] or 0.0)
        lines.append(
            f"| {name} | {pair(row['speed'])} | {pair(row['locked'])} | {row['speed']['without_accelerometer']:.3f} | "
            f"{pair(row['yaw_rate'])} | {row['yaw_rate_bias']['error']:.3f} | {slip:.2f} | "
            f"{pair(row['lateral_speed'])} |"
        )
    return "\n".join(lines)


def finish(runs: list[Drive]) -> str:
    """Number of finished races, and the mean of their best laps."""
    done = [one.best for one in runs if one.outcome == "finished" and one.best is not None]
    mean = f", {sum(done) / len(done):.2f} s" if len(done) == len(runs) else ""
    return f"{len(done)} of {len(runs)}{mean}"


def race_table(by: dict[str, dict[bool, dict[str, list[Drive]]]]) -> str:
    """Races finished with and without the estimate."""
    head = "".join(f" `{name}`, sensors | `{name}`, estimate |" for name in by)
    lines = [f"| case |{head}", "|---|" + "---:|" * 2 * len(by)]
    for case in CASES:
        cells = "".join(f" {finish(one[estimated][case.name])} |" for one in by.values() for estimated in (False, True))
        lines.append(f"| {case.name} |{cells}")
    return "\n".join(lines)


def main(folder: pathlib.Path) -> None:
    """Writes the page and its plots."""
    by = {name: {flag: drives_of(name, flag) for flag in (False, True)} for name in SETUPS}
    sensors = load_car("default").core.values()["sensors"]
    parts = [HEAD.read_text(encoding="utf-8").format(laps=LAPS, seed=SEED, tracks=", ".join(TRACKS), **sensors)]
    parts += [f"\nSetup `{name}`:\n\n{error_table(both[True])}\n" for name, both in by.items()]
    parts.append(CASE_LIST.format(cases="; ".join(f"`{case.name}`, {case.description}" for case in CASES)))
    for case, file in PICTURES.items():
        track, setup = DRAWN
        shown = by[setup][True][case][TRACKS.index(track)]
        plot_drive(shown, f"{track}, setup {setup}: {shown.case.description}", folder / file)
        parts.append(f"\n![{shown.case.description}]({file})\n")
    parts.append(
        "\n## Races\n\nRaces finished, and the mean of the best laps if all did, with the measured state and with "
        "the estimate:\n\n"
    )
    parts.append(race_table(by) + "\n")
    (folder / "estimation.md").write_text("".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
