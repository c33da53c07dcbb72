"""Plots a recording on its map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from firstlap.evaluation.perception.ground_truth import LEFT as LEFT_SIDE
from firstlap.evaluation.perception.ground_truth import RIGHT as RIGHT_SIDE
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, RIGHT
from firstlap.plots.primitives import new_figure, save

if TYPE_CHECKING:
    from firstlap.evaluation.perception.map_comparison import MapComparison

LINE, WALL = "#2e7d32", "#c4ccd3"
SHOWN = 60_000
AHEAD_SHOWN = 25
"""Points of each line drawn: some 3 m ahead of the car, so that lines do not hide each other."""


def plot_against_map(found: MapComparison, path: str | Path) -> None:
    """Writes a plot of perceived walls by side and planned centerlines on the map; lines of failures in red."""
    corners = np.vstack(found.track.walls)
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    height = float(np.clip(12.0 * (high[1] - low[1]) / (high[0] - low[0]), 3.5, 16.0)) + 1.8
    figure = new_figure(13.0, height)
    axes = figure.add_axes((0.05, 0.5 / height, 0.93, 1.0 - 1.8 / height))
    axes.set_aspect("equal")
    axes.tick_params(colors=FAINT, labelsize=9)
    _draw_walls(axes, found)
    _draw_lines(axes, found)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    title = f"{found.name} on its map"
    figure.text(0.02, 1.0 - 0.35 / height, title, fontsize=17, fontweight="bold", color=INK, parse_math=False)
    figure.text(0.02, 1.0 - 0.65 / height, _summary(found), fontsize=11, color=INK, parse_math=False)
    figure.legend(
        handles=_legend(),
        loc="upper right",
        ncols=5,
        frameon=False,
        fontsize=9,
        bbox_to_anchor=(0.99, 1.0 - 0.75 / height),
    )
    save(figure, path)


def _draw_walls(axes: Axes, found: MapComparison) -> None:
    """Those of the map, and the points that were labeled as walls."""
    for wall in found.track.walls:
        axes.plot(*wall.T, color=WALL, linewidth=5.0, solid_capstyle="round", zorder=1)
    for side, color in ((LEFT_SIDE, LEFT), (RIGHT_SIDE, RIGHT)):
        points = np.vstack([*found.walls[side], np.zeros((0, 2))])
        thin = max(1, len(points) // SHOWN)
        axes.scatter(points[::thin, 0], points[::thin, 1], s=1.2, color=color, linewidths=0, alpha=0.5, zorder=3)


def _draw_lines(axes: Axes, found: MapComparison) -> None:
    for bad, color, width, order in ((False, LINE, 0.5, 4), (True, BAD, 0.9, 5)):
        lines = [
            line[:AHEAD_SHOWN]
            for line, is_bad in zip(found.lines, found.perception.bad, strict=True)
            if is_bad == bad and len(line) > 1
        ]
        axes.add_collection(LineCollection(lines, colors=color, linewidths=width, alpha=0.5, zorder=order))


def _summary(found: MapComparison) -> str:
    metrics = found.perception.to_dict()
    error = metrics["error"]["2"]
    said = (
        f"setup {found.setup.name}, {metrics['scans']} scans, bad {100 * (metrics['bad'] or 0.0):.1f} %, "
        f"precision {100 * (metrics['precision'] or 0.0):.1f} %, recall {100 * (metrics['recall'] or 0.0):.1f} %"
    )
    if error["median"] is not None:
        said += f", 2 m ahead {1000 * error['median']:.0f} mm off in the median, {1000 * error['p95']:.0f} mm at 95 %"
    return said


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], color=WALL, linewidth=5, label="walls of the map"),
        Line2D([], [], color=LEFT, marker="o", linestyle="none", markersize=5, label="labeled left wall"),
        Line2D([], [], color=RIGHT, marker="o", linestyle="none", markersize=5, label="labeled right wall"),
        Line2D([], [], color=LINE, linewidth=2, label="centerlines planned"),
        Line2D([], [], color=BAD, linewidth=2, label="of failures"),
    ]
