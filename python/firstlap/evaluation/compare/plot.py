"""Plots a comparison: lines on the track, speeds along the lap, bars of lap times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from firstlap.common.text import counted, short_name
from firstlap.evaluation.compare.compare import Comparison, Entry
from firstlap.evaluation.compare.record import Line
from firstlap.plots.colors import BAD, FAINT, INK
from firstlap.plots.primitives import bare, draw_road, draw_start, draw_walls, new_figure, save

COLORS = ("#6a1b9a", "#e8710a", "#1f77b4", "#2e7d32", "#c2185b", "#00838f", "#8d6e63", "#455a64", "#9e9d24", "#d84315")


def plot_comparison(comparison: Comparison, path: str | Path) -> None:
    """Writes the plot. Raises InputError."""
    save(comparison_figure(comparison), path)


def comparison_figure(comparison: Comparison) -> Figure:
    """Track with the lines of the fastest laps, their speeds, and all flying laps as bars."""
    figure = new_figure(15.0, 10.5)
    title = f"{short_name(comparison.track.name)}, {comparison.track.length:.1f} m"
    figure.text(0.03, 0.965, title, fontsize=19, fontweight="bold", color=INK, va="center", parse_math=False)
    details = f"car {comparison.car.name}   ·   {counted(comparison.laps, 'lap')} x {counted(comparison.seeds, 'seed')}"
    details += f"   ·   latency {comparison.latency}   ·   the lines are the fastest flying laps"
    figure.text(0.97, 0.965, details, fontsize=11, color=INK, va="center", ha="right", parse_math=False)
    lines = {entry.label: _fastest(entry) for entry in comparison.entries}
    colors = {entry.label: COLORS[i % len(COLORS)] for i, entry in enumerate(comparison.entries)}
    _draw_lines(figure.add_axes((0.02, 0.36, 0.60, 0.57)), comparison, lines, colors)
    _draw_bars(figure.add_axes((0.74, 0.40, 0.23, 0.50)), comparison, colors)
    _draw_speeds(figure.add_axes((0.06, 0.07, 0.91, 0.25)), comparison, lines, colors)
    return figure


def _fastest(entry: Entry) -> Line | None:
    records = [record for record in entry.records if record.laps]
    best = min(records, key=lambda record: min(lap.time for lap in record.flying), default=None)
    return best.line_of_best_lap() if best else None


def _draw_lines(axes: Axes, comparison: Comparison, lines: dict[str, Line | None], colors: dict[str, str]) -> None:
    bare(axes)
    draw_road(axes, comparison.track)
    draw_walls(axes, comparison.track)
    draw_start(axes, comparison.track)
    for label, line in lines.items():
        if line is not None:
            axes.plot(line["x"], line["y"], color=colors[label], linewidth=1.8, alpha=0.9, label=label, zorder=4)
    for entry in comparison.entries:
        ends = [record.path for record in entry.records if record.contact and len(record.path["x"])]
        for path in ends:
            axes.plot(path["x"][-1], path["y"][-1], "x", color=colors[entry.label], markersize=9, markeredgewidth=2.2,
                      zorder=6)  # fmt: skip
    corners = np.vstack(comparison.track.walls)
    low, high = corners.min(axis=0) - 0.6, corners.max(axis=0) + 0.6
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])


def _draw_bars(axes: Axes, comparison: Comparison, colors: dict[str, str]) -> None:
    """Draws the median flying lap as a bar, every lap as a dot, and failed races as text."""
    axes.set_title("flying laps [s], bar: median", fontsize=11, color=INK, loc="left", pad=8)
    everything: list[float] = []
    for row, entry in enumerate(comparison.entries):
        summary = entry.summary()
        times = [lap.time for record in entry.records if record.finished for lap in record.flying]
        everything += times
        color = colors[entry.label]
        if times:
            axes.barh(row, summary["median"], height=0.62, color=color, alpha=0.35, zorder=2)
            heights = row + (np.linspace(-0.22, 0.22, len(times)) if len(times) > 1 else np.zeros(1))
            axes.plot(times, heights, "o", color=color, markersize=3, alpha=0.7, zorder=3)
            axes.text(max(times), row, f"  {summary['median']:.2f}", va="center", fontsize=10.5, color=INK,
                      fontweight="bold", zorder=5)  # fmt: skip
        lost = summary["runs"] - summary["finished"]
        if lost:
            text = f"{lost} of {summary['runs']} races not finished"
            axes.text(0.02, row + 0.42, text, va="center", fontsize=9, color=BAD, zorder=5,
                      transform=axes.get_yaxis_transform())  # fmt: skip
    axes.set_yticks(range(len(comparison.entries)), [entry.label for entry in comparison.entries], fontsize=10)
    axes.set_ylim(len(comparison.entries) - 0.4, -0.6)
    if everything:
        axes.set_xlim(0.0, 1.25 * max(everything))
    axes.tick_params(length=0, colors=INK)
    for name, spine in axes.spines.items():
        spine.set_visible(name == "bottom")
        spine.set_color(FAINT)


def _draw_speeds(axes: Axes, comparison: Comparison, lines: dict[str, Line | None], colors: dict[str, str]) -> None:
    axes.set_title("speed along the centerline [m/s]", fontsize=11, color=INK, loc="left", pad=8)
    for label, line in lines.items():
        if line is None or len(line["s"]) < 2:
            continue
        order = np.argsort(line["s"])
        axes.plot(line["s"][order], line["speed"][order], color=colors[label], linewidth=1.6, label=label)
    axes.set_xlim(0.0, comparison.track.length)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("distance from the start line [m]", fontsize=10, color=INK)
    axes.tick_params(colors=INK)
    axes.grid(color="#edf0f2", linewidth=0.8)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(FAINT)
    if any(line is not None for line in lines.values()):
        axes.legend(loc="upper right", bbox_to_anchor=(1.0, 1.17), ncols=6, frameon=False, fontsize=10, labelcolor=INK)
