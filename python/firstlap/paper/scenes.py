"""Single steps of a lap that show what the paper's figures show: sections, track width, centerline."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.drivers.racer import Racer
from firstlap.evaluation.perception.ground_truth import GroundTruth
from firstlap.evaluation.perception.metrics import to_world
from firstlap.plots.colors import BAD, DROPPED, FAINT, INK, LEFT, LINE, PAPER, RIGHT, WALL
from firstlap.plots.primitives import new_figure, write
from firstlap.sim.race import start_race
from firstlap.tracks.track import Track

SECTIONS = ("#1f77b4", "#e8710a", "#6a1b9a", "#00897b", "#c2185b", "#827717", "#5d4037")
"""Colors of neighboring sections."""
BOTH = 3
"""Value of `support` where both walls are seen."""
SAMPLES = 40
"""Points of the mean of both sides."""
EVERY = 4
"""Of so many scans, one is considered for the figures."""
WIDTH_BEYOND = 10.0
"""[m] How far ahead of the car the true width is looked up."""
HEADROOM = 1.15
"""Top of the axes of the width over the largest width."""
MARGIN = 0.6
"""[m] Shown around what is drawn."""

Points = npt.NDArray[np.float64]
Trace = Mapping[str, Any]


@dataclass(frozen=True)
class Scene:
    """One step: its trace, the true pose, and the distance from the start line [m]."""

    trace: Trace
    pose: tuple[float, float, float]
    at: float


@dataclass(frozen=True)
class Lap:
    """A flying lap: the most telling step for each figure, and the steering errors over the distance.

    errors: columns s, heading_error, cross_track_error, yaw_rate_error, steering_change; SI.
    """

    sections: Scene
    width: Scene
    middle: Scene
    errors: dict[str, Points]


ERRORS = ("heading_error", "cross_track_error", "yaw_rate_error", "steering_change")


def drive_lap(track: Track, setup: Setup, car: Car, seed: int) -> Lap | None:
    """Drives two laps and keeps the second one; None if the car does not get through it."""
    racer = Racer(setup, car)
    running = start_race(track, racer, car, laps=2, seed=seed)
    best: dict[str, tuple[float, Scene]] = {}
    rows: list[list[float]] = []
    step = 0
    while running.advance():
        if running.laps_done() < 1:
            continue
        trace = racer.trace
        rows.append([running.s, *(trace["steering"][name] for name in ERRORS)])
        step += 1
        if step % EVERY == 0 and len(trace["line"]["points"]) > 1:
            _keep_best(best, Scene(trace, running.pose, running.s))
    if running.result()["outcome"] != "finished" or len(best) < len(SCORES):
        return None
    columns = np.array(rows).T
    errors = dict(zip(("s", *ERRORS), columns, strict=True))
    return Lap(best["sections"][1], best["width"][1], best["middle"][1], errors)


def _keep_best(best: dict[str, tuple[float, Scene]], scene: Scene) -> None:
    for name, score in SCORES.items():
        value = score(scene.trace)
        if name not in best or value > best[name][0]:
            best[name] = (value, scene)


def _kept_sections(trace: Trace) -> float:
    return float(np.sum(np.asarray(trace["sections"]["status"]) == 0))


def _width_change(trace: Trace) -> float:
    seen = trace["line"]["width"][trace["line"]["support"] == BOTH]
    return float(np.ptp(seen)) if len(seen) else 0.0


def _mean_error(trace: Trace) -> float:
    mean = mean_of_sides(trace)
    if mean is None:
        return 0.0
    gaps = np.hypot(*(mean[:, None, :] - trace["line"]["points"][None, :, :]).transpose(2, 0, 1)).min(axis=1)
    return float(np.median(gaps))


SCORES: Mapping[str, Callable[[Trace], float]] = {
    "sections": _kept_sections,
    "width": _width_change,
    "middle": _mean_error,
}
"""What makes a step telling for a figure."""


def mean_of_sides(trace: Trace) -> Points | None:
    """(N, 2) the mean of both visible sides at equal shares of their lengths; None where one is missing."""
    left, right = (trace[side]["points"][trace[side]["age"] == 0.0] for side in ("left", "right"))
    if len(left) < 2 or len(right) < 2:
        return None
    share = np.linspace(0.0, 1.0, SAMPLES)
    return np.asarray(0.5 * (_along(left[::-1], share) + _along(right, share)))  # both from the car onward


def _along(points: Points, share: Points) -> Points:
    """Points at these shares of the length of a polyline."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    return np.column_stack([np.interp(share * length[-1], length, points[:, i]) for i in (0, 1)])


def draw_sections(scene: Scene, truth: GroundTruth) -> Figure:
    """The segmented scan: sections by color with their sides, and the centerline between them."""
    trace, points = scene.trace, scene.trace["points"]
    figure, axes = _scene_figure(scene, truth, points, "Segmented scan")
    sections = trace["sections"]
    colors = itertools.cycle(SECTIONS)
    for i, (first, last, fate) in enumerate(zip(sections["first"], sections["last"], sections["status"], strict=True)):
        piece = points[first : last + 1]
        color = next(colors) if fate == 0 else DROPPED
        axes.scatter(piece[:, 0], piece[:, 1], s=10, color=color, linewidths=0, zorder=3)
        if fate == 0:
            side = "right" if i < trace["split"] else "left"
            middle = piece[len(piece) // 2]
            box = {"facecolor": PAPER, "alpha": 0.85, "linewidth": 0, "pad": 1}
            axes.annotate(
                f"{i} {side}", middle, (6, 9), textcoords="offset points", fontsize=9, color=color, bbox=box, zorder=6
            )
    axes.plot(*trace["line"]["points"].T, color=LINE, linewidth=2.2, zorder=5)
    dropped = Line2D([], [], color=DROPPED, marker="o", linestyle="none", markersize=4, label="eliminated")
    _legend(axes, [dropped])
    return figure


def draw_middle(scene: Scene, truth: GroundTruth) -> Figure:
    """The centerline and the mean of both sides, where they differ most."""
    trace = scene.trace
    both = np.vstack([trace["left"]["points"], trace["right"]["points"], trace["line"]["points"]])
    figure, axes = _scene_figure(scene, truth, both, "Centerline and the mean of both sides")
    _draw_sides(axes, trace)
    mean = mean_of_sides(trace)
    if mean is not None:
        axes.plot(*mean.T, color=BAD, linewidth=1.8, linestyle=(0, (3, 2)), zorder=4)
    axes.plot(*trace["line"]["points"].T, color=LINE, linewidth=2.4, zorder=5)
    _legend(axes, [Line2D([], [], color=BAD, linewidth=1.8, linestyle="--", label="mean of both sides")])
    return figure


def draw_width(scene: Scene, truth: GroundTruth) -> Figure:
    """The track width along the centerline, estimated from one scan, and the true one."""
    line, start = scene.trace["line"], scene.pose
    figure = new_figure(10.0, 4.2)
    axes = figure.add_axes((0.07, 0.13, 0.91, 0.72))
    beyond = np.full(len(line["points"]), WIDTH_BEYOND)
    at = truth.beside(to_world(line["points"], start), truth.station(*start), MARGIN, beyond)[1]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line["points"], axis=0).T))])
    seen = np.where(line["support"] == BOTH, line["width"], np.nan)
    axes.plot(s, truth.width[at], color=FAINT, linewidth=3, label="true width")
    axes.plot(s, line["width"], color=LINE, linewidth=1.0, label="estimated where a wall is hidden")
    axes.plot(s, seen, color=LINE, linewidth=2.4, label="measured between both walls")
    axes.set_ylim(0.0, HEADROOM * float(max(truth.width[at].max(), line["width"].max())))
    axes.set_xlabel("distance along the centerline, from behind the car [m]")
    axes.set_ylabel("width [m]")
    axes.legend(fontsize=9, frameon=False, loc="lower center", ncols=3)
    axes.grid(color=FAINT, alpha=0.3, linewidth=0.6)
    write(figure, 0.02, 0.94, f"Track width from one scan, {scene.at:.1f} m after the start line", fontsize=13)
    return figure


def draw_errors(lap: Lap) -> Figure:
    """The four errors of the steering law over a lap."""
    titles: dict[str, tuple[str, Callable[[Points], Points]]] = {
        "heading_error": ("heading error Δψ [°]", np.degrees),
        "cross_track_error": ("cross-track error Δd [m]", np.asarray),
        "yaw_rate_error": ("yaw-rate error Δr [°/s]", np.degrees),
        "steering_change": ("steering change Δδ [°]", np.degrees),
    }
    figure = new_figure(11.0, 7.4)
    for row, (name, (title, unit)) in enumerate(titles.items()):
        axes = figure.add_subplot(len(titles), 1, row + 1)
        axes.plot(lap.errors["s"], unit(lap.errors[name]), color=LEFT, linewidth=1.2)
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set_title(title, fontsize=10, loc="left", color=INK)
        axes.grid(color=FAINT, alpha=0.3, linewidth=0.6)
        axes.set_xlim(0.0, float(lap.errors["s"].max()))
        axes.tick_params(labelsize=8, labelbottom=row == len(titles) - 1)
    axes.set_xlabel("distance from the start line [m]")
    figure.tight_layout()
    return figure


def _scene_figure(scene: Scene, truth: GroundTruth, shown: Points, title: str) -> tuple[Figure, Axes]:
    """A figure around `shown` with true walls, true medial line and the car, in base_link."""
    low, high = shown.min(axis=0) - MARGIN, shown.max(axis=0) + MARGIN
    low, high = np.minimum(low, -MARGIN), np.maximum(high, MARGIN)
    width = 10.0
    height = float(np.clip(width * (high[1] - low[1]) / (high[0] - low[0]), 3.0, 9.0)) + 0.9
    figure = new_figure(width, height)
    axes = figure.add_axes((0.05, 0.45 / height, 0.93, 1.0 - 1.1 / height))
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.tick_params(colors=FAINT, labelsize=8)
    walls, line = (to_car(points, scene.pose) for points in (truth.walls, truth.line))
    axes.scatter(walls[:, 0], walls[:, 1], s=7, color=WALL, linewidths=0, zorder=1)
    closed = np.vstack([line, line[:1]])
    axes.plot(*closed.T, color=FAINT, linewidth=1.0, linestyle=(0, (4, 3)), zorder=2)
    axes.plot(0.0, 0.0, ">", color=INK, markersize=11, zorder=6)
    write(figure, 0.02, 1.0 - 0.3 / height, f"{title}, {scene.at:.1f} m after the start line", fontsize=13)
    return figure, axes


def to_car(points: Points, pose: tuple[float, float, float]) -> Points:
    """Map frame to base_link."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray((points - pose[:2]) @ np.array([[c, -s], [s, c]]))


def _draw_sides(axes: Axes, trace: Trace) -> None:
    for side, color in (("left", LEFT), ("right", RIGHT)):
        points = trace[side]["points"][trace[side]["age"] == 0.0]
        axes.scatter(points[:, 0], points[:, 1], s=12, color=color, linewidths=0, zorder=3)


def _legend(axes: Axes, entries: list[Line2D]) -> None:
    common = [
        Line2D([], [], color=LINE, linewidth=2.2, label="centerline planned"),
        Line2D([], [], color=FAINT, linewidth=1.0, linestyle="--", label="true medial line"),
    ]
    axes.legend(handles=[*common, *entries], loc="best", fontsize=8, frameon=False)
