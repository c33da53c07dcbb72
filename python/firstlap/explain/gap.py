"""Plots one step of follow the gap: free runs, bubble, aim, arc."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from firstlap.common.text import signed
from firstlap.explain.local import PATH
from firstlap.explain.scene import (
    FREE,
    RETURN,
    Points,
    angle_panel,
    beam_angles,
    draw_aim,
    draw_arc,
    end_angle_panel,
    legend,
    opponents_figure,
    rays,
    stroke,
)
from firstlap.explain.snapshot import StepSnapshot
from firstlap.perception.scan import laser_of
from firstlap.plots.colors import BAD, INK


def draw_gap(snapshot: StepSnapshot) -> Figure:
    """The figure of a step of the driver `gap`."""
    trace = snapshot.trace
    aim = f"aim {signed(math.degrees(trace['aim']), 1)}°, free {trace['aim_free']:.2f} m"
    facts = f"{aim}   arc free {trace['arc_free']:.2f} m"
    figure, scene, panel = opponents_figure(snapshot, facts)
    angle_panel(panel, "free distance [m]")
    if len(trace["free"]) == 0:
        return figure
    angles = trace["step"] * (np.arange(len(trace["free"])) - len(trace["free"]) // 2)
    _draw_scene(scene, snapshot, angles)
    _draw_panel(panel, snapshot, angles)
    return figure


def _draw_scene(axes: Axes, snapshot: StepSnapshot, angles: Points) -> None:
    trace = snapshot.trace
    laser = laser_of(snapshot.car)
    ends = rays(snapshot, angles, trace["free"])
    axes.fill(*np.vstack([laser, ends]).T, color=FREE, alpha=0.10, linewidth=0, zorder=2)
    first, last = trace["run"]
    chosen = (angles >= first - 1e-9) & (angles <= last + 1e-9)
    axes.fill(*np.vstack([laser, ends[chosen]]).T, color=FREE, alpha=0.22, linewidth=0, zorder=2)
    radius = snapshot.params["gap"]["bubble_radius"]
    axes.add_patch(Circle(trace["nearest"], radius, facecolor="#c6282822", edgecolor=BAD, linewidth=1.4, zorder=4))
    axes.plot(*trace["nearest"], "x", color=BAD, markersize=8, markeredgewidth=2, zorder=5)
    draw_aim(axes, snapshot, trace["aim"], max(trace["aim_free"], 0.3), "aim")
    if trace["arc"] != trace["wanted"]:
        draw_arc(axes, snapshot, trace["wanted"], 1.5, BAD)
    draw_arc(axes, snapshot, trace["arc"], min(max(trace["arc_free"], 0.1), 3.0), INK)
    entries = [
        stroke(FREE, "free for the car", linewidth=8, alpha=0.15),
        stroke(FREE, "best run", linewidth=8, alpha=0.35),
        stroke(BAD, "bubble", linewidth=1.4),
        stroke(INK, "arc taken", linestyle=(0, (4, 2))),
        stroke(BAD, "desired arc, not free", linestyle=(0, (4, 2))),
    ]
    legend(axes, entries, snapshot)


def _draw_panel(axes: Axes, snapshot: StepSnapshot, angles: Points) -> None:
    trace = snapshot.trace
    beams = np.degrees(beam_angles(trace))
    axes.plot(beams, trace["ranges"], color=RETURN, linewidth=0.9, label="range")
    axes.fill_between(np.degrees(angles), trace["free"], color=FREE, alpha=0.12, linewidth=0)
    axes.plot(np.degrees(angles), trace["free"], color=FREE, linewidth=1.4, label="free for the car")
    first, last = trace["run"]
    axes.axvspan(math.degrees(first), math.degrees(last), color=FREE, alpha=0.10, linewidth=0)
    axes.axhline(trace["threshold"], color=BAD, linewidth=1.0, linestyle=(0, (3, 2)), label="counts as free")
    axes.axvline(math.degrees(trace["window"]), color=INK, linewidth=1.0, linestyle=(0, (2, 2)), label="best window")
    axes.axvline(math.degrees(trace["aim"]), color=PATH, linewidth=1.8, label="aim")
    end_angle_panel(axes, snapshot.params["gap"]["view_angle"] * 1.1, snapshot.params["scan"]["range_use"])
