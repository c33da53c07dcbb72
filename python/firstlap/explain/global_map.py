"""Plots a step of the map-based driver: map and scan, line, plan and margins."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from firstlap.explain.local import PATH
from firstlap.explain.scene import FREE, RETURN, legend, opponents_figure, stroke
from firstlap.explain.snapshot import StepSnapshot
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, RIGHT
from firstlap.plots.primitives import colored_line

EVERY = 5
"""Number of stages between two outlines of the car."""


def draw_global(snapshot: StepSnapshot) -> Figure:
    """The figure of a step of the driver `global`."""
    trace = snapshot.trace
    figure, scene, panel = opponents_figure(snapshot, _facts(snapshot))
    _draw_scene(figure, scene, snapshot)
    panel.set_position((0.715, 0.50, 0.265, 0.28))
    below = figure.add_axes((0.715, 0.10, 0.265, 0.29))
    for axes in (panel, below):
        axes.tick_params(colors=INK, labelsize=9.5)
        for name, spine in axes.spines.items():
            spine.set_visible(name in ("left", "bottom"))
            spine.set_color(FAINT)
    if len(trace["plan"]):
        _draw_speeds(panel, snapshot)
        _draw_margins(below, snapshot)
    return figure


def _facts(snapshot: StepSnapshot) -> str:
    trace = snapshot.trace
    estimate = trace["estimate"]
    if trace["pose"] is None:
        where = "no pose: lost"
    elif estimate is None:
        where = "true pose"
    else:
        where = f"{trace['particles']} particles ± {estimate['std']:.2f} m, {math.degrees(estimate['std_yaw']):.1f}°"
        where += f"   scan match {100.0 * estimate['fit']:.0f} %"
    return where + (f"   blocked after {trace['blocked_at']:.1f} m" if trace["blocked_at"] is not None else "")


def _draw_scene(figure: Figure, axes: Axes, snapshot: StepSnapshot) -> None:
    trace = snapshot.trace
    axes.scatter(trace["map"][:, 0], trace["map"][:, 1], s=5, color=INK, linewidths=0, marker="s", zorder=2)
    axes.scatter(trace["line"][:, 0], trace["line"][:, 1], s=6, color=FREE, linewidths=0, zorder=4)
    plan = trace["plan"]
    for pose in plan[EVERY - 1 :: EVERY]:
        axes.add_patch(
            Polygon(_outline(pose, snapshot.car), facecolor="none", edgecolor=PATH, linewidth=0.8, alpha=0.7, zorder=5)
        )
    if len(plan):
        drawn = colored_line(axes, plan[:, 0], plan[:, 1], trace["plan_speed"], 3.2, zorder=6)
        bar = figure.colorbar(drawn, cax=figure.add_axes((0.47, 0.875, 0.17, 0.012)), orientation="horizontal")
        bar.set_label("planned speed [m/s]", fontsize=9.5, color=INK)
        bar.outline.set_visible(False)
    estimate = trace["estimate"]
    if estimate is not None:
        color = BAD if estimate["lost"] else PATH
        axes.add_patch(Circle((0.0, 0.0), max(3.0 * estimate["std"], 0.02), color=color, alpha=0.35, zorder=9))
    entries = [
        stroke(INK, "wall in the map", linestyle="none", marker="s", markersize=4),
        stroke(FREE, "racing line", linewidth=2.0),
        stroke(PATH, "plan, car every 0.15 s", linewidth=1.2),
        stroke(PATH, "3 σ of the particles", linestyle="none", marker="o", markersize=6, alpha=0.5),
    ]
    legend(axes, entries, snapshot)


def _outline(pose: np.ndarray, car: object) -> np.ndarray:
    g: dict[str, float] = dict(car)  # type: ignore[call-overload]
    rear, half = -g["rear_overhang"], 0.5 * g["width"]
    front = rear + g["length"]
    corners = np.array([[rear, -half], [front, -half], [front, half], [rear, half]])
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + pose[:2])


def _draw_speeds(axes: Axes, snapshot: StepSnapshot) -> None:
    trace = snapshot.trace
    time = trace["plan_time"]
    axes.set_title("speed over the plan [m/s]", fontsize=11, color=INK, loc="left", pad=8)
    axes.plot(time, trace["line_speed_ahead"], color=FREE, linewidth=5.0, alpha=0.35, label="racing line")
    axes.plot(time, trace["plan_speed"], color=PATH, linewidth=2.0, label="planned")
    axes.plot(0.0, snapshot.speed, "o", color=RETURN, label="measured")
    axes.set_ylim(0.0, 1.15 * max(float(trace["line_speed_ahead"].max()), float(trace["plan_speed"].max()), 1.0))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3, frameon=False, fontsize=9, labelcolor=INK)


def _draw_margins(axes: Axes, snapshot: StepSnapshot) -> None:
    trace = snapshot.trace
    time = trace["plan_time"]
    axes.set_title("lateral clearance in the map [m]", fontsize=11, color=INK, loc="left", pad=8)
    axes.plot(time, trace["left"], color=LEFT, linewidth=1.6, label="left")
    axes.plot(time, trace["right"], color=RIGHT, linewidth=1.6, label="right")
    margin = snapshot.params["mpc"]["margin"]
    axes.axhline(margin, color=BAD, linewidth=1.0, linestyle=(0, (3, 2)), label="margin: penalized below")
    axes.set_ylim(min(0.0, float(min(trace["left"].min(), trace["right"].min()))), None)
    axes.set_xlabel("seconds ahead", fontsize=9.5, color=INK)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3, frameon=False, fontsize=9, labelcolor=INK)
