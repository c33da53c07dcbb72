"""Plots one step of PID center following: beams, walls from them, error, terms."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from firstlap.common.text import signed
from firstlap.explain.local import PATH
from firstlap.explain.scene import draw_arc, legend, opponents_figure, rays, stroke
from firstlap.explain.snapshot import StepSnapshot
from firstlap.perception.scan import laser_of
from firstlap.plots.colors import BAD, INK, LEFT, RIGHT

TERMS = (("p_term", "k_p e"), ("i_term", "∫ k_i e"), ("d_term", "k_d de/dt"))


def draw_pid(snapshot: StepSnapshot) -> Figure:
    """The figure of a step of the driver `pid`."""
    trace = snapshot.trace
    facts = f"{trace['error']:+.2f} m to the center, {trace['preview']:.2f} m ahead   arc free {trace['free']:.2f} m"
    figure, scene, panel = opponents_figure(snapshot, facts)
    if len(trace["ranges"]):
        _draw_scene(scene, snapshot)
    panel.set_position((0.775, 0.4, 0.205, 0.35))
    _draw_terms(panel, snapshot)
    return figure


def _draw_scene(axes: Axes, snapshot: StepSnapshot) -> None:
    trace, params = snapshot.trace, snapshot.params["center"]
    laser = np.array(laser_of(snapshot.car))
    ahead = laser + np.array([trace["preview"], 0.0])
    for name, sign, color in (("left", 1.0, LEFT), ("right", -1.0, RIGHT)):
        wall = trace[name]
        angles = sign * np.array([params["side_angle"], params["ahead_angle"]])
        ends = rays(snapshot, angles, np.array([wall["side"], wall["ahead"]]))
        for end in ends:
            axes.plot(*np.vstack([laser, end]).T, color=color, linewidth=1.6, zorder=6)
        axes.plot(*ends.T, "o", color=color, markersize=6, zorder=7)
        along = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-6)
        line = np.vstack([ends[0] - along, ends[1] + 2.0 * along])
        axes.plot(*line.T, color=color, linewidth=1.2, linestyle=(0, (4, 2)), zorder=5)
        normal = sign * np.array([-math.sin(sign * wall["angle"]), math.cos(wall["angle"])])
        foot = ahead + normal * wall["preview"]
        axes.plot(*np.vstack([ahead, foot]).T, color=PATH, linewidth=1.0, linestyle=(0, (2, 2)), zorder=6)
    axes.plot(*ahead, "o", color=INK, markersize=5, zorder=8)
    middle = ahead + np.array([0.0, trace["error"]])
    axes.plot(*middle, "o", markersize=12, markerfacecolor="none", markeredgecolor=PATH,
              markeredgewidth=2.2, zorder=9)  # fmt: skip
    draw_arc(axes, snapshot, trace["result"][1], min(max(trace["free"], 0.1), 4.0), INK)
    entries = [
        stroke(LEFT, "left beams and wall", marker="o", markersize=4),
        stroke(RIGHT, "right beams and wall", marker="o", markersize=4),
        stroke(PATH, "distances at the preview", linestyle=(0, (2, 2))),
        stroke(PATH, "center", linestyle="none", marker="o", markerfacecolor="none", markersize=8),
        stroke(INK, "free arc", linestyle=(0, (4, 2))),
    ]
    legend(axes, entries, snapshot)


def _draw_terms(axes: Axes, snapshot: StepSnapshot) -> None:
    """Draws the terms of the steering angle and the command, in degrees."""
    trace = snapshot.trace
    values = [math.degrees(trace[key]) for key, _ in TERMS] + [math.degrees(trace["result"][1])]
    reach = max(6.0, *(abs(value) for value in values)) * 1.6
    for row, value in enumerate(values):
        axes.barh(row, value, height=0.58, color=INK if row == len(TERMS) else PATH, alpha=0.9, zorder=3)
        shift = 0.02 * reach * (1 if value >= 0 else -1)
        side = "right" if value >= 0 else "left"
        axes.text(value + shift, row, f"{signed(value, 2)}°", va="center", ha=side, fontsize=10, color=INK, zorder=4)
    limit = math.degrees(snapshot.car["steering_limit"])
    for sign in (-1, 1) if limit < reach else ():
        axes.axvline(sign * limit, color=BAD, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1)
    axes.axvline(0.0, color=INK, linewidth=0.8, zorder=2)
    axes.set_xlim(reach, -reach)
    axes.set_ylim(len(values) - 0.4, -0.6)
    axes.set_yticks(range(len(values)), [name for _, name in TERMS] + ["commanded"], fontsize=9.5, color=INK)
    axes.tick_params(length=0, labelsize=9.5, colors=INK)
    axes.set_xticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_title("steering angle: left ← → right", fontsize=10.5, color=INK, loc="right", pad=8)
