"""Shared elements of the step plots of the reactive drivers: the scan around the car, and ranges over angle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from firstlap.explain.local import PATH, SCENE, SIZE, draw_car, legend_below, write_head
from firstlap.explain.snapshot import StepSnapshot
from firstlap.perception.scan import laser_of, ray_ends
from firstlap.plots.colors import FAINT, GRID, INK, WALL
from firstlap.plots.colors import FREE as FREE
from firstlap.plots.colors import RETURN as RETURN
from firstlap.plots.primitives import new_figure

Points = npt.NDArray[np.float64]
REACH = (-2.5, 11.0, -6.5, 6.5)


def beam_angles(trace: Any) -> Points:
    """(beams,) angle of each range of a trace [rad], right to left."""
    return np.asarray(trace["first_beam"] + trace["beam_step"] * np.arange(len(trace["ranges"])))


def rays(snapshot: StepSnapshot, angles: Points, ranges: Points) -> Points:
    """(N, 2) endpoints of rays from the LiDAR, in base_link [m]."""
    return ray_ends(laser_of(snapshot.car), angles, ranges)


def opponents_figure(snapshot: StepSnapshot, facts: str) -> tuple[Figure, Axes, Axes]:
    """Figure, scene and the panel beside it; the scene holds walls, returns and car."""
    figure = new_figure(*SIZE)
    scene = figure.add_axes(SCENE)
    write_head(figure, snapshot, facts)
    _frame(scene, snapshot)
    for wall, visible in snapshot.walls:
        style = "solid" if visible else (0, (1, 1.5))
        scene.plot(*wall.T, color=WALL, linewidth=5.0, linestyle=style, solid_capstyle="round", zorder=1)
    if len(snapshot.trace["ranges"]):
        ends = rays(snapshot, beam_angles(snapshot.trace), snapshot.trace["ranges"])
        scene.scatter(ends[:, 0], ends[:, 1], s=6, color=RETURN, linewidths=0, zorder=3)
    draw_car(scene, snapshot.car, snapshot.steering_angle, snapshot.trace["result"][1])
    return figure, scene, figure.add_axes((0.725, 0.15, 0.255, 0.62))


def _frame(axes: Axes, snapshot: StepSnapshot) -> None:
    """Sets the limits to the extent of the scan."""
    axes.set_aspect("equal")
    extent = np.array([[-1.0, -1.0], [3.0, 1.0]])
    if len(snapshot.trace["ranges"]):
        extent = np.vstack([extent, rays(snapshot, beam_angles(snapshot.trace), snapshot.trace["ranges"])])
    extent = np.clip(extent, (REACH[0], REACH[2]), (REACH[1], REACH[3]))
    low, high = extent.min(axis=0) - 0.4, extent.max(axis=0) + 0.4
    ratio = SCENE[2] * SIZE[0] / (SCENE[3] * SIZE[1])
    width = max(high[0] - low[0], ratio * (high[1] - low[1]))
    middle = 0.5 * (low + high)
    axes.set_xlim(middle[0] - 0.5 * width, middle[0] + 0.5 * width)
    axes.set_ylim(middle[1] - 0.5 * width / ratio, middle[1] + 0.5 * width / ratio)
    axes.set_facecolor("#fbfbfc")
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=FAINT, labelsize=9)
    for spine in axes.spines.values():
        spine.set_color("#d5dade")


def angle_panel(axes: Axes, title: str) -> None:
    """Prepares a panel of distance over angle, with left angles on the left."""
    axes.set_title(title, fontsize=11, color=INK, loc="left", pad=8)
    axes.set_xlabel("left ← angle from straight ahead [°] → right", fontsize=9.5, color=INK)
    axes.tick_params(colors=INK, labelsize=9.5)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(FAINT)
    axes.axvline(0.0, color=FAINT, linewidth=0.8, zorder=1)


def end_angle_panel(axes: Axes, view: float, top: float) -> None:
    """Sets the limits: `view` [rad] to either side, `top` [m]."""
    axes.set_xlim(math.degrees(view), -math.degrees(view))
    axes.set_ylim(0.0, 1.05 * top)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=3, frameon=False, fontsize=9, labelcolor=INK)


def draw_aim(axes: Axes, snapshot: StepSnapshot, angle: float, distance: float, label: str) -> None:
    """Draws a ray from the LiDAR with a ring at its end."""
    ends = rays(snapshot, np.array([angle, angle]), np.array([0.0, distance]))
    axes.plot(*ends.T, color=PATH, linewidth=1.6, zorder=7)
    axes.plot(*ends[1], "o", markersize=12, markerfacecolor="none", markeredgecolor=PATH, markeredgewidth=2.2, zorder=9)
    axes.annotate(label, ends[1], textcoords="offset points", xytext=(10, 8), fontsize=10, color=PATH, zorder=9)


def draw_arc(axes: Axes, snapshot: StepSnapshot, steering_angle: float, length: float, color: str) -> None:
    """Draws the path of the rear axle at a steering angle [rad] over `length` [m]."""
    s = np.linspace(0.0, length, 100)
    curvature = math.tan(steering_angle) / snapshot.car["wheelbase"]
    yaw = curvature * s
    x = s * np.sinc(yaw / np.pi)
    y = s * np.sinc(0.5 * yaw / np.pi) * np.sin(0.5 * yaw)
    axes.plot(x, y, color=color, linewidth=1.6, linestyle=(0, (4, 2)), zorder=6)


def legend(axes: Axes, entries: list[Line2D], snapshot: StepSnapshot) -> None:
    """Draws the legend below the scene."""
    common = [Line2D([], [], marker="o", linestyle="none", color=RETURN, label="return", markersize=4)]
    if snapshot.walls:
        common.append(Line2D([], [], color=WALL, linewidth=4, label="true walls"))
    legend_below(axes, [*entries, *common])


def stroke(color: str, label: str, **options: Any) -> Line2D:
    """A line entry of a legend."""
    return Line2D([], [], color=color, label=label, **options)
