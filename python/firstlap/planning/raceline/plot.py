"""Plots a racing line with its speeds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from firstlap.planning.raceline.line import RaceLine
from firstlap.plots.colors import INK
from firstlap.plots.primitives import bare, colored_line, draw_road, draw_start, draw_walls, new_figure, save
from firstlap.tracks.track import Track


def plot_line(line: RaceLine, track: Track, path: str | Path) -> None:
    """Writes the line colored by speed between the walls, and the speeds along the lap. Raises InputError."""
    corners = np.vstack(track.walls)
    low, high = corners.min(axis=0), corners.max(axis=0)
    span = np.maximum(high - low, 1.0)
    width = 11.0
    above = float(np.clip(width * span[1] / span[0], 4.0, 9.5))
    below = 2.4
    height = above + below
    figure = new_figure(width, height)
    axes = figure.add_axes((0.03, (below + 0.1) / height, 0.94, (above - 0.6) / height))
    bare(axes)
    draw_road(axes, track)
    draw_walls(axes, track)
    draw_start(axes, track)
    closed = np.vstack([line.path.points, line.path.points[:1]])
    speed = np.append(line.speed, line.speed[0])
    colors = colored_line(axes, closed[:, 0], closed[:, 1], speed, 2.6, zorder=4)
    axes.set_xlim(low[0] - 0.5, high[0] + 0.5)
    axes.set_ylim(low[1] - 0.5, high[1] + 0.5)
    title = f"{Path(line.name).stem}   ·   line {line.length:.1f} m   ·   lap {line.lap_time:.2f} s"
    figure.text(0.03, 1.0 - 0.3 / height, title, fontsize=14, fontweight="bold", color=INK, va="center")
    graph = figure.add_axes((0.07, 0.55 / height, 0.80, (below - 0.85) / height))
    stations = np.append(line.path.stations, line.length)
    graph.plot(stations, speed, color=INK, linewidth=1.4)
    graph.set_xlim(0.0, line.length)
    graph.set_ylim(0.0, 1.08 * float(speed.max()))
    graph.set_xlabel("distance along the line [m]", color=INK)
    graph.set_ylabel("speed [m/s]", color=INK)
    for side in ("top", "right"):
        graph.spines[side].set_visible(False)
    bar = figure.add_axes((0.90, 0.55 / height, 0.015, (below - 0.85) / height))
    scale = figure.colorbar(colors, cax=bar)
    scale.set_label("speed [m/s]", color=INK)
    scale.outline.set_visible(False)
    save(figure, path)
