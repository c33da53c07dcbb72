"""Building blocks of plots: figures, colored lines, road and walls of a track."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from firstlap.common.files import check_writable, write_whole
from firstlap.common.text import printable
from firstlap.plots.colors import FAINT, INK, PAPER, ROAD, SPEED_MAP
from firstlap.tracks.track import Track

PICTURE_SUFFIXES = (".png", ".svg", ".pdf", ".jpg")

Points = npt.NDArray[np.float64]


def new_figure(width: float, height: float) -> Figure:
    """A figure of that size [in] without a window."""
    figure = Figure(figsize=(width, height), facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: str | Path) -> None:
    """Writes the figure atomically. Raises InputError."""
    write_whole(check_writable(path, PICTURE_SUFFIXES), lambda name: figure.savefig(name, dpi=140))


def write(figure: Figure, x: float, y: float, text: str, **options: Any) -> None:
    """Writes text with names of files or setups literally: no math mode, and any bytes."""
    figure.text(x, y, printable(text), color=INK, va="center", parse_math=False, **options)


def colored_line(axes: Axes, x: Points, y: Points, value: Points, width: float, **options: Any) -> LineCollection:
    """A line through (x, y) colored by `value`."""
    joints = np.column_stack([x, y])
    pieces = np.stack([joints[:-1], joints[1:]], axis=1)
    line = LineCollection(list(pieces), cmap=SPEED_MAP, linewidths=width, capstyle="round", **options)
    line.set_array(0.5 * (value[:-1] + value[1:]))
    axes.add_collection(line)
    return line


def bare(axes: Axes) -> None:
    """Removes ticks and frame and sets an equal aspect ratio."""
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_road(axes: Axes, track: Track) -> None:
    """Draws the road between the walls, from the centerline and its widths."""
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
    """Draws walls; dotted if invisible to the LiDAR, faint if not solid."""
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
    """Draws the start line with an arrow in the direction of travel."""
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
