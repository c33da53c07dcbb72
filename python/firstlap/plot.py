"""Pictures of races. Colours and parts that the other pictures share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from firstlap.colours import BAD as BAD
from firstlap.colours import FAINT as FAINT
from firstlap.colours import INK as INK
from firstlap.colours import LEFT as LEFT
from firstlap.colours import PAPER as PAPER
from firstlap.colours import RIGHT as RIGHT
from firstlap.colours import ROAD, SPEED_MAP
from firstlap.output import check_writable, write_whole
from firstlap.text import printable, short_name
from firstlap.tracks.track import Track

if TYPE_CHECKING:
    from firstlap.race import RaceResult

PICTURES = (".png", ".svg", ".pdf", ".jpg")

Points = npt.NDArray[np.float64]


def new_figure(width: float, height: float) -> Figure:
    """A figure that needs no window, in inches."""
    figure = Figure(figsize=(width, height), facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: str | Path) -> None:
    """Writes the figure whole or not at all. Raises InputError."""
    write_whole(check_writable(path, PICTURES), lambda name: figure.savefig(name, dpi=140))


def write(figure: Figure, x: float, y: float, text: str, **options: Any) -> None:
    """Text that holds names of files or setups, as it is: no formula, and with whatever bytes they have."""
    figure.text(x, y, printable(text), color=INK, va="center", parse_math=False, **options)


def coloured_line(axes: Axes, x: Points, y: Points, value: Points, width: float, **options: Any) -> LineCollection:
    """A line through (x, y) coloured by `value`."""
    joints = np.column_stack([x, y])
    pieces = np.stack([joints[:-1], joints[1:]], axis=1)
    line = LineCollection(list(pieces), cmap=SPEED_MAP, linewidths=width, capstyle="round", **options)
    line.set_array(0.5 * (value[:-1] + value[1:]))
    axes.add_collection(line)
    return line


def bare(axes: Axes) -> None:
    """Takes ticks and frame away and keeps a metre a metre."""
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_road(axes: Axes, track: Track) -> None:
    """The ground between the walls, from the centerline and its widths."""
    line = track.centerline
    ahead = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
    normal = np.column_stack([-ahead[:, 1], ahead[:, 0]]) / np.hypot(*ahead.T)[:, None]
    for i in range(len(line)):
        j = (i + 1) % len(line)
        corners = [
            line[i] + normal[i] * track.width_left[i],
            line[j] + normal[j] * track.width_left[j],
            line[j] - normal[j] * track.width_right[j],
            line[i] - normal[i] * track.width_right[i],
        ]
        axes.add_patch(Polygon(corners, closed=True, facecolor=ROAD, edgecolor=ROAD, linewidth=1.2, zorder=0))


def draw_walls(axes: Axes, track: Track, *, color: str = INK, width: float = 1.6) -> None:
    """Walls; what the LiDAR does not see dotted, what the car may cross faint."""
    for wall, visible, solid in zip(track.walls, track.visible, track.solid, strict=True):
        style = (0, (1.0, 1.4)) if not visible else "solid"
        axes.plot(
            *wall.T,
            color=color if solid else FAINT,
            linewidth=width if solid else 0.7,
            linestyle=style,
            zorder=2,
        )


def draw_start(axes: Axes, track: Track) -> None:
    """The start and finish line with an arrow in the direction of travel."""
    x, y, yaw = track.start_pose()
    across = np.array([-np.sin(yaw), np.cos(yaw)])
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    ends = np.array([[x, y] + across * track.width_left[0], [x, y] - across * track.width_right[0]])
    axes.plot(*ends.T, color=INK, linewidth=1.2, linestyle=(0, (2, 1.5)), zorder=3)
    tip = ends[1] - across * 0.35
    axes.annotate(
        "",
        xy=tip + ahead * 1.0,
        xytext=tip,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.2},
        zorder=3,
    )


def plot_race(result: RaceResult, path: str | Path) -> None:
    """Writes the driven line coloured by speed on the track, with the lap times. Raises InputError."""
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
        line = coloured_line(axes, driven["x"], driven["y"], driven["speed"], 2.2, zorder=4, alpha=0.9)
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
