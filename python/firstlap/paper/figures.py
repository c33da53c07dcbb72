"""The other figures of the report: architecture, track, driven lines, comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from firstlap.evaluation.published import LAPS_BY_GROUP, NOT_ROBUST, SETTING_LAPS
from firstlap.paper.settings import SettingResult
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, LINE, PATH, RIGHT, ROAD
from firstlap.plots.primitives import bare, draw_road, draw_start, draw_walls, new_figure
from firstlap.tracks.track import Track

ARCHITECTURE: Mapping[str, tuple[str, ...]] = {
    "sensors": ("LiDAR scan", "wheel speed", "yaw rate"),
    "perception": ("points", "sections", "left and right wall", "track width"),
    "estimation": ("velocity, yaw rate", "speed scale"),
    "planning": ("centerline", "smoothing, spline", "velocity profile"),
    "control": ("lookahead", "Stanley, four terms", "limits"),
    "actuators": ("steering angle", "speed"),
}
"""The boxes of the paper's block diagram (its Figure 1) and what is in them here."""
BOXES: Mapping[str, tuple[float, float]] = {
    "sensors": (0.0, 0.5),
    "perception": (1.0, 1.0),
    "estimation": (1.0, 0.0),
    "planning": (2.0, 1.0),
    "control": (3.0, 0.5),
    "actuators": (4.0, 0.5),
}
"""Column and row of each box."""
ARROWS = (
    ("sensors", "perception"),
    ("sensors", "estimation"),
    ("perception", "planning"),
    ("estimation", "planning"),
    ("estimation", "control"),
    ("planning", "control"),
    ("control", "actuators"),
)
LINES = (FAINT, LEFT, LINE, RIGHT, "#00838f", PATH, BAD)
"""Color of each setting's driven line."""
SCALE_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
"""[m] Lengths of a scale bar."""


def draw_architecture() -> Figure:
    """The block diagram: layers, and what is in them."""
    figure = new_figure(12.0, 4.6)
    axes = figure.add_axes((0.01, 0.02, 0.98, 0.96))
    bare(axes)
    axes.set_aspect("auto")
    axes.set_xlim(-0.5, 4.5)
    axes.set_ylim(-0.55, 1.55)
    for source, target in ARROWS:
        _arrow(axes, BOXES[source], BOXES[target])
    for name, (x, y) in BOXES.items():
        corner = (x - 0.33, y - 0.38)
        axes.add_patch(
            FancyBboxPatch(corner, 0.66, 0.76, boxstyle="round,pad=0.02", facecolor=ROAD, edgecolor=INK, zorder=2)
        )
        axes.text(x, y + 0.27, name, ha="center", va="center", fontsize=13, fontweight="bold", color=INK, zorder=3)
        for row, text in enumerate(ARCHITECTURE[name]):
            axes.text(x, y + 0.12 - 0.125 * row, text, ha="center", va="center", fontsize=10, color=INK, zorder=3)
    return figure


def _arrow(axes: Axes, source: tuple[float, float], target: tuple[float, float]) -> None:
    tail, tip = (source[0] + 0.36, source[1]), (target[0] - 0.36, target[1])
    axes.annotate("", xy=tip, xytext=tail, arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.3}, zorder=1)


def draw_layout(track: Track) -> Figure:
    """The track with a scale bar and its measures."""
    figure, axes = _track_figure(track)
    low, high = _corners(track)
    length = max([bar for bar in SCALE_BARS if bar <= 0.3 * (high[0] - low[0])], default=SCALE_BARS[0])
    x, y = low[0], low[1] - 0.9
    axes.plot([x, x + length], [y, y], color=INK, linewidth=3.0, solid_capstyle="butt")
    axes.text(x + 0.5 * length, y - 0.15, f"{length:g} m", ha="center", va="top", fontsize=11, color=INK)
    width = track.width
    said = f"centerline {track.length:.1f} m, width {width.min():.2f} / {np.median(width):.2f} / {width.max():.2f} m"
    axes.text(high[0], y, f"{said} (min, median, max)", ha="right", va="center", fontsize=11, color=INK)
    axes.set_ylim(low[1] - 1.8, high[1] + 0.5)
    return figure


def draw_driven_lines(track: Track, driven: Sequence[SettingResult]) -> Figure:
    """A flying lap of every setting that finished, on the track."""
    figure, axes = _track_figure(track)
    for place, (one, color) in enumerate(zip(driven, LINES, strict=False)):
        finished = [result for result in one.results if result.finished]
        if not finished:
            continue
        path, laps = finished[0].path, finished[0].laps
        end = sum(lap.time for lap in laps)
        kept = (path["time"] >= end - laps[-1].time) & (path["time"] <= end)
        axes.plot(path["x"][kept], path["y"][kept], color=color, linewidth=1.5, label=f"setting {place}", zorder=4)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=7, frameon=False, fontsize=9)
    return figure


def draw_distances(driven: Sequence[SettingResult]) -> Figure:
    """Distance of a flying lap over the settings."""
    figure = new_figure(11.0, 3.2)
    axes = figure.add_subplot()
    for place, one in enumerate(driven):
        if one.distance is not None:
            axes.plot(place, one.distance, "o", color=LEFT, markersize=7)
            axes.annotate(f"{one.distance:.2f}", (place, one.distance), (0, 8), textcoords="offset points", ha="center")
    axes.set_xticks(range(len(driven)), [str(place) for place in range(len(driven))])
    axes.set_xlabel("setting")
    axes.set_ylabel("distance of a lap [m]")
    axes.margins(y=0.3)
    axes.grid(color=FAINT, alpha=0.3, linewidth=0.6)
    figure.tight_layout()
    return figure


def draw_comparison(found: Mapping[str, Any]) -> Figure:
    """Median laps of the drivers beside the paper's laps of Section V-B; hatched: tuned by a search."""
    rows = [row for row in found["entries"] if row["median"] is not None]
    paper = {f"paper: {group}": lap for group, lap in LAPS_BY_GROUP.items()}
    paper["paper: not robust"] = SETTING_LAPS[NOT_ROBUST]
    figure = new_figure(11.0, 0.42 * (len(rows) + len(paper)) + 1.2)
    axes = figure.add_subplot()
    for place, (label, lap) in enumerate(paper.items()):
        axes.barh(place, lap, color=RIGHT, alpha=0.75)
        axes.text(lap, place, f" {lap:g}", va="center", fontsize=9, color=INK)
        axes.text(0.1, place, label, va="center", fontsize=9, color=INK)
    for place, row in enumerate(rows, start=len(paper)):
        axes.barh(
            place, row["median"], color=LEFT, alpha=0.6, hatch="//" if row["tuned_for"] else "", edgecolor="white"
        )
        said = f"{row['median']:.2f}, {row['finished']} of {row['runs']}"
        axes.text(row["median"], place, f" {said}", va="center", fontsize=9, color=INK)
        tuned = f"tuned for {row['tuned_for']}" if row["tuned_for"] else "untuned"
        name = f"{row['label']} ({tuned})"
        box = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1}
        axes.text(0.1, place, name, va="center", fontsize=9, color=INK, bbox=box, parse_math=False)
    axes.set_yticks([])
    axes.invert_yaxis()
    axes.margins(x=0.18)
    axes.set_xlabel("lap [s]; the paper's laps are of another track")
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    figure.tight_layout()
    return figure


def _corners(track: Track) -> tuple[Any, Any]:
    corners = np.vstack(track.walls)
    return corners.min(axis=0), corners.max(axis=0)


def _track_figure(track: Track) -> tuple[Figure, Axes]:
    low, high = _corners(track)
    height = float(np.clip(11.0 * (high[1] - low[1]) / (high[0] - low[0]), 4.0, 11.0)) + 0.8
    figure = new_figure(11.0, height)
    axes = figure.add_axes((0.02, 0.6 / height, 0.96, 1.0 - 0.8 / height))
    bare(axes)
    draw_road(axes, track)
    draw_walls(axes, track, width=1.1)
    draw_start(axes, track)
    axes.set_xlim(low[0] - 0.5, high[0] + 0.5)
    axes.set_ylim(low[1] - 0.5, high[1] + 0.5)
    return figure, axes
