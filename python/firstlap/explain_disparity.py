"""The picture of one step of the disparity extender: ranges before and after, disparities, the farthest block."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from firstlap.explain import Moment
from firstlap.explain_plot import PATH
from firstlap.explain_scene import (
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
from firstlap.plot import BAD, INK
from firstlap.scan import laser_of
from firstlap.text import signed


def draw_disparity(moment: Moment) -> Figure:
    """The figure of a step of the driver `disparity`."""
    trace = moment.trace
    facts = f"aim {signed(math.degrees(trace['aim']), 1)}°, free {trace['aim_free']:.2f} m"
    for side in ("left", "right"):
        if trace[f"held_{side}"]:
            facts += f"   no turning {side}: too near"
    figure, scene, panel = opponents_figure(moment, facts)
    angle_panel(panel, "ranges, and after the extension [m]")
    if len(trace["extended"]) == 0:
        return figure
    angles = beam_angles(trace)
    _draw_scene(scene, moment, angles)
    _draw_panel(panel, moment, angles)
    return figure


def _draw_scene(axes: Axes, moment: Moment, angles: Points) -> None:
    trace = moment.trace
    inside = np.abs(angles) <= moment.params["disparity"]["view_angle"]
    laser = laser_of(moment.car)
    before = rays(moment, angles[inside], trace["ranges"][inside])
    after = rays(moment, angles[inside], trace["extended"][inside])
    axes.fill(*np.vstack([laser, before]).T, color=BAD, alpha=0.10, linewidth=0, zorder=2)
    axes.fill(*np.vstack([laser, after]).T, color="#ffffff", linewidth=0, zorder=2)
    axes.fill(*np.vstack([laser, after]).T, color=FREE, alpha=0.10, linewidth=0, zorder=2)
    first, last = trace["block"]
    block = rays(moment, angles[first : last + 1], trace["extended"][first : last + 1])
    axes.fill(*np.vstack([laser, block]).T, color=FREE, alpha=0.25, linewidth=0, zorder=2)
    edges = trace["disparities"]
    corners = rays(moment, angles[edges], trace["ranges"][edges])
    axes.plot(*corners.T, "x", color=BAD, markersize=8, markeredgewidth=2, zorder=6)
    draw_aim(axes, moment, trace["aim"], trace["aim_free"], "aim")
    entries = [
        stroke(FREE, "left after the extension", linewidth=8, alpha=0.15),
        stroke(FREE, "farthest block", linewidth=8, alpha=0.35),
        stroke(BAD, "taken away by extension", linewidth=8, alpha=0.15),
        stroke(BAD, "nearer end of a disparity", linestyle="none", marker="x", markersize=7, markeredgewidth=2),
    ]
    legend(axes, entries, moment)


def _draw_panel(axes: Axes, moment: Moment, angles: Points) -> None:
    trace = moment.trace
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
    end_angle_panel(axes, moment.params["disparity"]["view_angle"] * 1.1, moment.params["scan"]["range_use"])
