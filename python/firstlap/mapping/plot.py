"""Plots a map: cells, driven path and loop closure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap

from firstlap.mapping.make import MapResult
from firstlap.mapping.occupancy_map import UNKNOWN
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, PAPER, RIGHT
from firstlap.plots.primitives import bare, new_figure, save


def plot_map(result: MapResult, path: str | Path, title: str, details: str) -> None:
    """Writes the plot. Raises InputError."""
    drawn = result.map
    known_rows, known_columns = (np.flatnonzero((drawn.cells != UNKNOWN).any(axis=axis)) for axis in (1, 0))
    rows, columns = drawn.cells.shape
    x, y, _ = drawn.origin
    extent = (x, x + columns * drawn.resolution, y, y + rows * drawn.resolution)
    span = np.array([np.ptp(known_columns), np.ptp(known_rows)]) * drawn.resolution + 1.0
    width = 11.0
    height = float(np.clip(width * span[1] / span[0], 4.5, 10.0)) + 1.2
    figure = new_figure(width, height)
    axes = figure.add_axes((0.03, 0.5 / height, 0.94, 1.0 - 1.3 / height))
    bare(axes)
    colors = ListedColormap([PAPER, INK, "#d5dae0"])
    axes.imshow(
        drawn.cells, cmap=colors, vmin=0, vmax=2, origin="lower", extent=extent, interpolation="nearest", zorder=0
    )
    axes.plot(*result.before[:, :2].T, color=FAINT, linewidth=1.0, label="before the loop was closed", zorder=2)
    axes.plot(*result.poses[:, :2].T, color=LEFT, linewidth=1.4, label="driven path", zorder=3)
    ends = [[result.poses[edge.first, :2], result.poses[edge.last, :2]] for edge in result.mapper.loops]
    for number, pair in enumerate(ends):
        label = "same place" if number == 0 else None
        axes.plot(*np.array(pair).T, color=RIGHT, linewidth=1.0, marker=".", markersize=3, label=label, zorder=4)
    start = drawn.start or (0.0, 0.0, 0.0)
    axes.annotate(
        "",
        xy=(start[0] + np.cos(start[2]), start[1] + np.sin(start[2])),
        xytext=start[:2],
        arrowprops={"arrowstyle": "-|>", "color": BAD, "linewidth": 1.6},
        zorder=5,
    )
    low = np.array([x + known_columns[0] * drawn.resolution, y + known_rows[0] * drawn.resolution])
    axes.set_xlim(low[0] - 0.3, low[0] + span[0] - 0.7)
    axes.set_ylim(low[1] - 0.3, low[1] + span[1] - 0.7)
    figure.text(
        0.03, 1.0 - 0.4 / height, title, fontsize=19, fontweight="bold", color=INK, va="center", parse_math=False
    )
    figure.text(0.97, 1.0 - 0.4 / height, details, fontsize=11, color=INK, va="center", ha="right", parse_math=False)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="lower left", ncols=3, frameon=False, fontsize=10, labelcolor=INK
    )
    save(figure, path)
