"""Plots one step of the disparity extender: ranges before and after the extension, disparities, aim."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from firstlap.common.text import signed
from firstlap.explain.local import PATH
from firstlap.explain.scene import (
    FREE,
    RETURN,
    Points,
    angle_panel,
    beam_angles,
    draw_aim,
    end_angle_panel,
    legend,
    opponents_figure,
    rays,
    stroke,
)
from firstlap.explain.snapshot import StepSnapshot
from firstlap.perception.scan import laser_of
from firstlap.plots.colors import BAD, INK


def draw_disparity(snapshot: StepSnapshot) -> Figure:
    """The figure of a step of the driver `disparity`."""
    trace = snapshot.trace
    facts = f"aim {signed(math.degrees(trace['aim']), 1)}°, free {trace['aim_free']:.2f} m"
    for side in ("left", "right"):
        if trace[f"held_{side}"]:
            facts += f"   no turn to the {side}: wall too close"
    figure, scene, panel = opponents_figure(snapshot, facts)
    angle_panel(panel, "ranges, and after the extension [m]")
    if len(trace["extended"]) == 0:
        return figure
    angles = beam_angles(trace)
    _draw_scene(scene, snapshot, angles)
    _draw_panel(panel, snapshot, angles)
    return figure


def _draw_scene(axes: Axes, snapshot: StepSnapshot, angles: Points) -> None:
    trace = snapshot.trace
    inside = np.abs(angles) <= snapshot.params["disparity"]["view_angle"]
    laser = laser_of(snapshot.car)
    before = rays(snapshot, angles[inside], trace["ranges"][inside])
    after = rays(snapshot, angles[inside], trace["extended"][inside])
    axes.fill(*np.vstack([laser, before]).T, color=BAD, alpha=0.10, linewidth=0, zorder=2)
    axes.fill(*np.vstack([laser, after]).T, color="#ffffff", linewidth=0, zorder=2)
    axes.fill(*np.vstack([laser, after]).T, color=FREE, alpha=0.10, linewidth=0, zorder=2)
    first, last = trace["block"]
    block = rays(snapshot, angles[first : last + 1], trace["extended"][first : last + 1])
    axes.fill(*np.vstack([laser, block]).T, color=FREE, alpha=0.25, linewidth=0, zorder=2)
    edges = trace["disparities"]
    corners = rays(snapshot, angles[edges], trace["ranges"][edges])
    axes.plot(*corners.T, "x", color=BAD, markersize=8, markeredgewidth=2, zorder=6)
    draw_aim(axes, snapshot, trace["aim"], trace["aim_free"], "aim")
    entries = [
        stroke(FREE, "free after the extension", linewidth=8, alpha=0.15),
        stroke(FREE, "farthest block", linewidth=8, alpha=0.35),
        stroke(BAD, "removed by the extension", linewidth=8, alpha=0.15),
        stroke(BAD, "nearer end of a disparity", linestyle="none", marker="x", markersize=7, markeredgewidth=2),
    ]
    legend(axes, entries, snapshot)


def _draw_panel(axes: Axes, snapshot: StepSnapshot, angles: Points) -> None:
    trace = snapshot.trace
    degrees = np.degrees(angles)
    axes.plot(degrees, trace["ranges"], color=RETURN, linewidth=0.9, label="range")
    axes.plot(degrees, trace["extended"], color=FREE, linewidth=1.5, label="extended")
    axes.fill_between(degrees, trace["extended"], trace["ranges"], color=BAD, alpha=0.12, linewidth=0)
    first, last = trace["block"]
    axes.axvspan(degrees[first], degrees[last], color=FREE, alpha=0.12, linewidth=0)
    edges = trace["disparities"]
    axes.plot(degrees[edges], trace["ranges"][edges], "x", color=BAD, markersize=7, label="disparity")
    axes.axvline(math.degrees(trace["aim"]), color=PATH, linewidth=1.8, label="aim")
    axes.axhline(trace["straight_free"], color=INK, linewidth=0.8, linestyle=(0, (2, 2)), label="straight ahead")
    end_angle_panel(axes, snapshot.params["disparity"]["view_angle"] * 1.1, snapshot.params["scan"]["range_use"])
