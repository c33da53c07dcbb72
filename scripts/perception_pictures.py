"""Reproduce the paper's perception figures with scans on our tracks.

Usage: scripts/perception_pictures.py FOLDER
"""

import pathlib
import sys
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.drivers.racer import Racer
from firstlap.evaluation.perception.ground_truth import GroundTruth
from firstlap.evaluation.perception.metrics import to_world
from firstlap.paper.scenes import mean_of_sides, to_car
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, RIGHT
from firstlap.plots.primitives import new_figure, save
from firstlap.sim.race import start_race
from firstlap.tracks.library import load_track

LINE = "#2e7d32"
SECTIONS = ("#1f77b4", "#e8710a", "#6a1b9a", "#00897b", "#c2185b", "#827717", "#5d4037")
Points = npt.NDArray[np.float64]
Pose = tuple[float, float, float]


def drive_to(name: str, station: float, laps: int = 2) -> tuple[dict[str, Any], Pose, GroundTruth]:
    """Trace, pose and truth of the first scan past `station` [m] in the second lap."""
    track, setup, car = load_track(name), load_setup("sure"), load_car("default")
    racer = Racer(setup, car)
    race = start_race(track, racer, car, laps=laps, seed=1)
    while race.advance() and not (race.laps_done() == 1 and station <= race.s < station + 1.0):
        pass
    return racer.trace, race.pose, GroundTruth.of(track)


def scene(
    axes: Axes, trace: dict[str, Any], pose: Pose, truth: GroundTruth, reach: tuple[float, float, float, float]
) -> None:
    """True walls and medial line, and the car."""
    axes.set_aspect("equal")
    axes.set_xlim(reach[0], reach[1])
    axes.set_ylim(reach[2], reach[3])
    axes.tick_params(colors=FAINT, labelsize=8)
    walls = to_car(truth.walls, pose)
    axes.scatter(walls[:, 0], walls[:, 1], s=7, color="#d5dade", linewidths=0, zorder=1)
    line = to_car(truth.line, pose)
    axes.plot(
        [*line[:, 0], line[0, 0]],
        [*line[:, 1], line[0, 1]],
        color=FAINT,
        linewidth=1.0,
        linestyle=(0, (4, 3)),
        zorder=2,
    )
    axes.plot([-0.1, 0.43], [0.0, 0.0], color=INK, linewidth=6, solid_capstyle="butt", zorder=6)


def slalom(folder: pathlib.Path) -> None:
    """The segmented slalom: sections, the gaps between them, and where the track continues."""
    trace, pose, truth = drive_to("slalom", 21.5)
    figure = new_figure(10.0, 4.6)
    axes = figure.add_axes((0.05, 0.08, 0.93, 0.8))
    scene(axes, trace, pose, truth, (-1.5, 8.0, -3.2, 3.2))
    sections, points = trace["sections"], trace["points"]
    for i, (first, last, fate) in enumerate(zip(sections["first"], sections["last"], sections["status"], strict=True)):
        piece = points[first : last + 1]
        color = SECTIONS[i % len(SECTIONS)] if fate == 0 else "#9aa4af"
        axes.scatter(piece[:, 0], piece[:, 1], s=10, color=color, linewidths=0, zorder=3)
        if fate == 0:
            side = "right" if i < trace["split"] else "left"
            axes.annotate(
                f"{i} {side}", piece[len(piece) // 2], (0, 9), textcoords="offset points", fontsize=9, color=color
            )
    axes.plot(*trace["line"]["points"].T, color=LINE, linewidth=2.2, zorder=5)
    figure.text(0.02, 0.935, "slalom: sections of wall, their sides, and the line between them", fontsize=13, color=INK)
    legend = [
        Line2D([], [], color=LINE, linewidth=2.2, label="planned centerline"),
        Line2D([], [], color=FAINT, linewidth=1.0, linestyle="--", label="true medial line"),
        Line2D([], [], color="#9aa4af", marker="o", linestyle="none", markersize=4, label="eliminated"),
    ]
    axes.legend(handles=legend, loc="lower right", fontsize=8, frameon=False)
    save(figure, folder / "perception_slalom.png")


def width(folder: pathlib.Path) -> None:
    """The width step from 1 m to 2 m within one scan."""
    track = load_track("width_step")
    narrow = track.width < 1.2
    step = int(np.flatnonzero(narrow & ~np.roll(narrow, -1))[0])
    trace, pose, truth = drive_to("width_step", float(track.stations[step]) - 0.8)
    figure = new_figure(10.0, 5.2)
    axes = figure.add_axes((0.06, 0.45, 0.92, 0.46))
    scene(axes, trace, pose, truth, (-1.0, 7.0, -1.5, 1.5))
    for side, color in (("left", LEFT), ("right", RIGHT)):
        axes.scatter(*trace[side]["points"].T, s=10, color=color, linewidths=0, zorder=3)
    line = trace["line"]
    axes.plot(*line["points"].T, color=LINE, linewidth=2.2, zorder=5)
    below = figure.add_axes((0.06, 0.1, 0.92, 0.27), sharex=axes)
    at = truth.beside(to_world(line["points"], pose), truth.station(*pose), 2.0, np.full(len(line["points"]), 10.0))[1]
    below.plot(line["points"][:, 0], truth.width[at], color=FAINT, linewidth=3, label="true width")
    seen = np.where(line["support"] == 3, line["width"], np.nan)
    below.plot(
        line["points"][:, 0], line["width"], color=LINE, linewidth=1.0, label="estimated where a wall is occluded"
    )
    below.plot(line["points"][:, 0], seen, color=LINE, linewidth=2.2, label="measured")
    below.set_ylim(0.6, 2.4)
    below.set_ylabel("width [m]", fontsize=9)
    below.set_xlabel("m ahead", fontsize=9)
    below.legend(fontsize=8, frameon=False, loc="lower center")
    below.tick_params(labelsize=8)
    figure.text(0.02, 0.945, "width_step: from 1 m to 2 m within one scan", fontsize=13, color=INK)
    save(figure, folder / "perception_width.png")


def middle(folder: pathlib.Path) -> None:
    """A hairpin, where part of a side is occluded and the mean of both sides is not the centerline."""
    trace, pose, truth = drive_to("hairpins", 20.0)
    left, right = (trace[side]["points"][trace[side]["age"] == 0.0] for side in ("left", "right"))
    mean = mean_of_sides(trace)
    assert mean is not None
    figure = new_figure(8.0, 6.4)
    axes = figure.add_axes((0.07, 0.07, 0.91, 0.83))
    both = np.vstack([left, right, trace["line"]["points"]])
    low, high = both.min(axis=0) - 0.6, both.max(axis=0) + 0.6
    scene(axes, trace, pose, truth, (low[0], high[0], low[1], high[1]))
    for points, color in ((left, LEFT), (right, RIGHT)):
        axes.scatter(*points.T, s=12, color=color, linewidths=0, zorder=3)
    axes.plot(*mean.T, color=BAD, linewidth=1.8, linestyle=(0, (3, 2)), zorder=4)
    axes.plot(*trace["line"]["points"].T, color=LINE, linewidth=2.4, zorder=5)
    figure.text(0.02, 0.945, "hairpins: the mean of both sides is not the centerline", fontsize=13, color=INK)
    legend = [
        Line2D([], [], color=LINE, linewidth=2.4, label="planned centerline"),
        Line2D([], [], color=BAD, linewidth=1.8, linestyle="--", label="mean of both sides"),
        Line2D([], [], color=FAINT, linewidth=1.0, linestyle="--", label="true medial line"),
    ]
    axes.legend(handles=legend, loc="best", fontsize=8, frameon=False)
    save(figure, folder / "perception_middle.png")


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    slalom(target)
    width(target)
    middle(target)
