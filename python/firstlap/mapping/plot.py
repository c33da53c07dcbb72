"""Plots a map: cells, driven path and loop closure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

from firstlap.mapping.make import MapResult
from firstlap.mapping.occupancy_map import UNKNOWN, OccupancyMap
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, PAPER, RIGHT
from firstlap.plots.primitives import bare, new_figure, save
from firstlap.tracks.track import FloatArray


def plot_map(result: MapResult, path: str | Path, title: str, details: str) -> None:
    """Writes the plot. Raises InputError."""
    low, span = _known_part(result.map)
    width = 11.0
    height = float(np.clip(width * (span[1] + 1.0) / (span[0] + 1.0), 4.5, 10.0)) + 1.2
    figure = new_figure(width, height)
    axes = figure.add_axes((0.03, 0.5 / height, 0.94, 1.0 - 1.3 / height))
    bare(axes)
    _draw_cells(axes, result.map)
    _draw_path(axes, result)
    _draw_start(axes, result.map)
    axes.set_xlim(low[0] - 0.3, low[0] + span[0] + 0.3)
    axes.set_ylim(low[1] - 0.3, low[1] + span[1] + 0.3)
    top = 1.0 - 0.4 / height
    figure.text(0.03, top, title, fontsize=19, fontweight="bold", color=INK, va="center", parse_math=False)
    figure.text(0.97, top, details, fontsize=11, color=INK, va="center", ha="right", parse_math=False)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="lower left", ncols=3, frameon=False, fontsize=10, labelcolor=INK
    )
    save(figure, path)


def _known_part(drawn: OccupancyMap) -> tuple[FloatArray, FloatArray]:
    """Lower left corner and size [m] of the rectangle around all known cells."""
    known = drawn.cells != UNKNOWN
    columns, rows = (np.flatnonzero(known.any(axis=axis)) for axis in (0, 1))
    low = np.array(drawn.origin[:2]) + drawn.resolution * np.array([columns[0], rows[0]])
    return low, np.array([np.ptp(columns), np.ptp(rows)]) * drawn.resolution


def _draw_cells(axes: Axes, drawn: OccupancyMap) -> None:
    rows, columns = drawn.cells.shape
    x, y, _ = drawn.origin
    extent = (x, x + columns * drawn.resolution, y, y + rows * drawn.resolution)
    colors = ListedColormap([PAPER, INK, "#d5dae0"])
    axes.imshow(
        drawn.cells, cmap=colors, vmin=0, vmax=2, origin="lower", extent=extent, interpolation="nearest", zorder=0
    )


def _draw_path(axes: Axes, result: MapResult) -> None:
    axes.plot(*result.before[:, :2].T, color=FAINT, linewidth=1.0, label="before the loop was closed", zorder=2)
    axes.plot(*result.poses[:, :2].T, color=LEFT, linewidth=1.4, label="driven path", zorder=3)
    ends = [[result.poses[edge.first, :2], result.poses[edge.last, :2]] for edge in result.mapper.loops]
    for number, pair in enumerate(ends):
        label = "same place" if number == 0 else None
        axes.plot(*np.array(pair).T, color=RIGHT, linewidth=1.0, marker=".", markersize=3, label=label, zorder=4)


def _draw_start(axes: Axes, drawn: OccupancyMap) -> None:
    x, y, yaw = drawn.start or (0.0, 0.0, 0.0)
    axes.annotate(
        "",
        xy=(x + np.cos(yaw), y + np.sin(yaw)),
        xytext=(x, y),
        arrowprops={"arrowstyle": "-|>", "color": BAD, "linewidth": 1.6},
        zorder=5,
    )
