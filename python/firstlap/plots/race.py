"""Plots a race."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from firstlap.common.text import short_name
from firstlap.plots.colors import BAD, INK, PAPER
from firstlap.plots.primitives import bare, colored_line, draw_road, draw_start, draw_walls, new_figure, save, write

if TYPE_CHECKING:
    from firstlap.sim.race import RaceResult


def plot_race(result: RaceResult, path: str | Path) -> None:
    """Writes the driven line colored by speed on the track, with the lap times. Raises InputError."""
    corners = np.vstack(result.track.walls)
    low, high = corners.min(axis=0), corners.max(axis=0)
    span = np.maximum(high - low, 1.0)
    width = 11.0
    height = float(np.clip(width * span[1] / span[0], 4.5, 10.0)) + 1.6
    figure = new_figure(width, height)
    axes = figure.add_axes((0.03, 1.15 / height, 0.94, 1.0 - 1.95 / height))
    bare(axes)
    draw_road(axes, result.track)
    draw_walls(axes, result.track)
    draw_start(axes, result.track)
    driven = result.path
    if len(driven["x"]) > 1:
        line = colored_line(axes, driven["x"], driven["y"], driven["speed"], 2.2, zorder=4, alpha=0.9)
        bar = figure.add_axes((0.62, 0.55 / height, 0.34, 0.14 / height))
        scale = figure.colorbar(line, cax=bar, orientation="horizontal")
        scale.set_label("speed [m/s]", color=INK, fontsize=10)
        scale.ax.tick_params(colors=INK, labelsize=9)
        scale.outline.set_visible(False)
    if result.contact:
        axes.plot(result.contact.x, result.contact.y, "X", color=BAD, markersize=13, markeredgecolor=PAPER, zorder=6)
        axes.annotate(
            f"contact at {result.contact.time:.2f} s",
            (result.contact.x, result.contact.y),
            textcoords="offset points",
            xytext=(10, 10),
            color=BAD,
            fontsize=11,
            fontweight="bold",
            zorder=6,
        )
    margin = 0.6
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    _write_labels(figure, result, height)
    save(figure, path)


def _write_labels(figure: Figure, result: RaceResult, height: float) -> None:
    track = result.track
    name = short_name(track.name)
    write(figure, 0.03, 1.0 - 0.42 / height, name, fontsize=19, fontweight="bold")
    direction = "" if result.direction == "forward" else ", reverse"
    details = (
        f"{track.length:.1f} m{direction}   ·   setup {result.setup.name}   ·   car {result.car.name}"
        f"   ·   seed {result.seed}   ·   {result.outcome.replace('_', ' ')}"
    )
    write(figure, 0.97, 1.0 - 0.42 / height, details, fontsize=11, ha="right")
    laps = result.laps[:8]
    for row, lap in enumerate(laps):
        best = lap.time == result.best
        standing = "  standing start" if lap.standing else ""
        figure.text(
            0.03 + 0.27 * (row // 4),
            (0.92 - 0.22 * (row % 4)) / height,
            f"lap {row + 1}   {lap.time:6.2f} s   {lap.mean_speed:.2f} m/s{standing}",
            fontsize=11,
            family="monospace",
            fontweight="bold" if best else "normal",
            color=INK,
            va="center",
        )
    if not laps:
        figure.text(0.03, 0.6 / height, "no complete lap", fontsize=11, color=INK, va="center")
