"""The picture of a recording held against its map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from firstlap.perception.truth import LEFT as LEFT_SIDE
from firstlap.perception.truth import RIGHT as RIGHT_SIDE
from firstlap.plot import BAD, FAINT, INK, LEFT, RIGHT, new_figure, save

if TYPE_CHECKING:
    from firstlap.perception.against_map import AgainstMap

LINE = "#2e7d32"
SHOWN = 60_000
AHEAD_SHOWN = 25
"""Points of each line drawn: some 3 m ahead of the car, so that lines do not hide each other."""


def plot_against_map(found: AgainstMap, path: str | Path) -> None:
    """Writes walls seen by side and centerlines planned over the map's walls; bad scans' lines in red."""
    figure = new_figure(13.0, 10.0)
    axes = figure.add_axes((0.05, 0.05, 0.93, 0.84))
    axes.set_aspect("equal")
    axes.tick_params(colors=FAINT, labelsize=9)
    for wall in found.track.walls:
        axes.plot(*wall.T, color="#c4ccd3", linewidth=5.0, solid_capstyle="round", zorder=1)
    for side, colour in ((LEFT_SIDE, LEFT), (RIGHT_SIDE, RIGHT)):
        points = np.vstack([*found.walls[side], np.zeros((0, 2))])
        thin = max(1, len(points) // SHOWN)
        axes.scatter(points[::thin, 0], points[::thin, 1], s=1.2, color=colour, linewidths=0, alpha=0.5, zorder=3)
    for bad, colour, width, order in ((False, LINE, 0.5, 4), (True, BAD, 0.9, 5)):
        lines = [
            line[:AHEAD_SHOWN]
            for line, is_bad in zip(found.lines, found.perception.bad, strict=True)
            if is_bad == bad and len(line) > 1
        ]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=width, alpha=0.5, zorder=order))
    points = np.vstack(found.track.walls)
    low, high = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    metrics = found.perception.to_dict()
    figure.text(0.02, 0.965, f"{found.name} on its map", fontsize=17, fontweight="bold", color=INK, parse_math=False)
    error = metrics["error"]["2"]
    said = (
        f"setup {found.setup.name}, {metrics['scans']} scans, bad {100 * (metrics['bad'] or 0.0):.1f} %, "
        f"precision {100 * (metrics['precision'] or 0.0):.1f} %, recall {100 * (metrics['recall'] or 0.0):.1f} %"
    )
    if error["median"] is not None:
        said += f", 2 m ahead {1000 * error['median']:.0f} mm off in the median, {1000 * error['p95']:.0f} mm at 95 %"
    figure.text(0.02, 0.935, said, fontsize=11, color=INK, parse_math=False)
    shown = [
        Line2D([], [], color="#c4ccd3", linewidth=5, label="the map's walls"),
        Line2D([], [], color=LEFT, marker="o", linestyle="none", markersize=5, label="seen as left wall"),
        Line2D([], [], color=RIGHT, marker="o", linestyle="none", markersize=5, label="seen as right wall"),
        Line2D([], [], color=LINE, linewidth=2, label="centerlines planned"),
        Line2D([], [], color=BAD, linewidth=2, label="of bad scans"),
    ]
    figure.legend(handles=shown, loc="upper right", ncols=5, frameon=False, fontsize=9, bbox_to_anchor=(0.99, 0.925))
    save(figure, path)
