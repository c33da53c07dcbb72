"""Plots one step of the map-less method."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle

from firstlap.common.text import signed
from firstlap.explain.snapshot import StepSnapshot
from firstlap.perception.scan import laser_of
from firstlap.plots.colors import BAD, DROPPED, FAINT, GOOD, GRID, INK, LEFT, LINE, PAIR, PAPER, RIGHT, WALL
from firstlap.plots.colors import PATH as PATH
from firstlap.plots.primitives import colored_line, new_figure, write

SCENE = (0.03, 0.075, 0.63, 0.835)
SIZE = (16.0, 9.2)
REACH = (-4.0, 10.5, -7.0, 7.0)
BOTH = 3
TERMS = (
    ("heading", "heading", "k_ang Δψ"),
    ("cross_track", "cross-track", "atan(k_dist Δd / …)"),
    ("yaw_rate", "yaw rate", "k_rate Δr"),
    ("steering", "steering change", "k_steer Δδ"),
)

Points = npt.NDArray[np.float64]


def draw_local(snapshot: StepSnapshot) -> Figure:
    """The figure of a step of the driver `local`."""
    figure = new_figure(*SIZE)
    scene = figure.add_axes(SCENE)
    _draw_scene(scene, snapshot)
    trace = snapshot.trace
    facts = f"track width {trace['width']:.2f} m"
    if len(trace["path"]["s"]):
        facts += f"   path {trace['path']['s'][-1] - trace['path']['s'][trace['nearest']]:.1f} m ahead"
    write_head(figure, snapshot, facts)
    _draw_terms(figure.add_axes((0.775, 0.555, 0.205, 0.225)), snapshot)
    _draw_profile(figure.add_axes((0.715, 0.09, 0.265, 0.345)), snapshot)
    return figure


def write_head(figure: Figure, snapshot: StepSnapshot, facts: str) -> None:
    """Writes title, status, command, measured state, and a line of facts."""
    speed, angle, status = snapshot.trace["result"]
    write(figure, 0.02, 0.962, snapshot.title, fontsize=19, fontweight="bold")
    write(figure, 0.02, 0.928, snapshot.subtitle, fontsize=10.5)
    color = GOOD if status == "ok" and not snapshot.outcome else BAD
    label = status.replace("_", " ") + (f", then {snapshot.outcome}" if snapshot.outcome else "")
    figure.text(0.69, 0.955, label, fontsize=17, fontweight="bold", color=color, va="center")
    rows = [
        ("command", f"{speed:5.2f} m/s", f"{signed(math.degrees(angle), 1, 6)}°"),
        ("measured", f"{snapshot.speed:5.2f} m/s", f"{signed(math.degrees(snapshot.steering_angle), 1, 6)}°"),
    ]
    for i, (name, first, second) in enumerate(rows):
        height = 0.912 - 0.032 * i
        figure.text(0.69, height, name, fontsize=12, color=INK, va="center")
        figure.text(0.77, height, first, fontsize=12, color=INK, va="center", family="monospace")
        figure.text(0.85, height, second, fontsize=12, color=INK, va="center", family="monospace")
    figure.text(0.69, 0.843, facts, fontsize=10.5, color=INK, va="center")


def _draw_scene(axes: Axes, snapshot: StepSnapshot) -> None:
    axes.set_aspect("equal")
    left, right, low, high = _view(snapshot.trace)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    axes.set_facecolor("#fbfbfc")
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=FAINT, labelsize=9)
    for spine in axes.spines.values():
        spine.set_color("#d5dade")
    for wall, visible in snapshot.walls:
        style = "solid" if visible else (0, (1, 1.5))
        axes.plot(*wall.T, color=WALL, linewidth=5.0, linestyle=style, solid_capstyle="round", zorder=1)
    _draw_points(axes, snapshot.trace)
    _draw_line(axes, snapshot.trace)
    _draw_path(axes, snapshot.trace)
    draw_car(axes, snapshot.params["car"], snapshot.steering_angle, snapshot.trace["result"][1])
    _draw_legend(axes, snapshot)


def _view(trace: Mapping[str, Any]) -> tuple[float, float, float, float]:
    """The limits of the scene, around the car, both walls and the path."""
    path = np.column_stack([trace["path"]["x"], trace["path"]["y"]])
    extent = np.vstack([[[-1.0, -1.0], [2.0, 1.0]], trace["left"]["points"], trace["right"]["points"], path])
    extent = np.clip(extent, (REACH[0], REACH[2]), (REACH[1], REACH[3]))
    low, high = extent.min(axis=0) - 0.5, extent.max(axis=0) + 0.5
    ratio = SCENE[2] * SIZE[0] / (SCENE[3] * SIZE[1])
    width = max(high[0] - low[0], ratio * (high[1] - low[1]))
    middle = 0.5 * (low + high)
    half = np.array([0.5 * width, 0.5 * width / ratio])
    (left, bottom), (right, top) = middle - half, middle + half
    return float(left), float(right), float(bottom), float(top)


def _draw_points(axes: Axes, trace: Mapping[str, Any]) -> None:
    """Draws returns by side, dropped sections in gray, and walls carried over as hollow markers."""
    points, sections = trace["points"], trace["sections"]
    colors = np.full(len(points), DROPPED, dtype=object)
    for i, (first, last, status) in enumerate(
        zip(sections["first"], sections["last"], sections["status"], strict=True)
    ):
        if status == 0:
            colors[first : last + 1] = RIGHT if i < trace["split"] else LEFT
    for color, size in ((DROPPED, 5), (RIGHT, 9), (LEFT, 9)):
        chosen = colors == color
        axes.scatter(points[chosen][:, 0], points[chosen][:, 1], s=size, color=color, linewidths=0, zorder=3)
    for side, color in (("left", LEFT), ("right", RIGHT)):
        wall = trace[side]
        old = wall["points"][wall["age"] > 0.0]
        axes.scatter(old[:, 0], old[:, 1], s=26, facecolors="none", edgecolors=color, linewidths=0.9, zorder=3)


def _draw_line(axes: Axes, trace: Mapping[str, Any]) -> None:
    """Draws width pairs and the centerline, and its smoothed and simplified versions."""
    line = trace["line"]
    both = line["support"] == BOTH
    pairs = np.stack([line["right"][both], line["left"][both]], axis=1)
    axes.add_collection(LineCollection(list(pairs[::2]), colors=PAIR, linewidths=0.6, alpha=0.75, zorder=2))
    axes.plot(*line["points"].T, color=LINE, linewidth=1.0, zorder=4)
    for side, wanted in (("left", 2), ("right", 1)):
        alone = line["support"] == wanted
        axes.scatter(
            line["points"][alone][:, 0],
            line["points"][alone][:, 1],
            s=12,
            color=LEFT if side == "left" else RIGHT,
            zorder=4,
            linewidths=0,
        )
    axes.scatter(line["points"][both][:, 0], line["points"][both][:, 1], s=9, color=LINE, zorder=4, linewidths=0)
    axes.plot(*trace["smoothed"].T, color=INK, linewidth=0.8, linestyle=(0, (4, 2)), zorder=5)
    axes.scatter(
        trace["simplified"][:, 0],
        trace["simplified"][:, 1],
        s=30,
        facecolors=PAPER,
        edgecolors=INK,
        linewidths=1.1,
        zorder=7,
    )


def _draw_path(axes: Axes, trace: Mapping[str, Any]) -> None:
    path = trace["path"]
    if len(path["s"]) < 2:
        return
    line = colored_line(axes, path["x"], path["y"], path["velocity"], 4.5, zorder=6, alpha=0.9)
    bar = axes.inset_axes((0.77, 0.945, 0.2, 0.018))
    bar.set_zorder(20)
    # Otherwise walls behind the scale could be read as part of it.
    axes.add_patch(
        Rectangle((0.745, 0.9), 0.25, 0.095, transform=axes.transAxes, color=PAPER, alpha=0.85, linewidth=0, zorder=19)
    )
    scale = axes.figure.colorbar(line, cax=bar, orientation="horizontal")
    scale.ax.tick_params(labelsize=8, colors=INK, length=2)
    scale.ax.set_title("planned speed [m/s]", fontsize=9, color=INK, pad=3)
    scale.outline.set_visible(False)
    ahead = trace["lookahead"]
    axes.plot(ahead["x"], ahead["y"], "o", markersize=13, markerfacecolor="none", markeredgecolor=PATH,
              markeredgewidth=2.4, zorder=10)  # fmt: skip
    reach = 0.7
    axes.annotate(
        "",
        xy=(ahead["x"] + reach * math.cos(ahead["yaw"]), ahead["y"] + reach * math.sin(ahead["yaw"])),
        xytext=(ahead["x"], ahead["y"]),
        arrowprops={"arrowstyle": "-|>", "color": PATH, "linewidth": 1.8, "shrinkA": 7},
        zorder=10,
    )


def draw_car(axes: Axes, car: Mapping[str, float], measured: float, commanded: float) -> None:
    """Draws the outline, wheels at the measured angle, and the commanded angle as an arrow from the front axle."""
    rear, length, width, wheelbase = -car["rear_overhang"], car["length"], car["width"], car["wheelbase"]
    axes.add_patch(
        Rectangle((rear, -width / 2), length, width, facecolor="#ffffffd0", edgecolor=INK, linewidth=1.6, zorder=8)
    )
    for x, angle in ((0.0, 0.0), (wheelbase, measured)):
        for side in (-1.0, 1.0):
            axes.add_patch(_wheel(x, side * (width / 2 - 0.03), angle))
    axes.plot(*laser_of(car), "o", markersize=3.5, color=INK, zorder=9)
    tip = (wheelbase + 0.75 * math.cos(commanded), 0.75 * math.sin(commanded))
    axes.annotate("", xy=tip, xytext=(wheelbase, 0.0),
                  arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.4}, zorder=9)  # fmt: skip


def _wheel(x: float, y: float, angle: float) -> Polygon:
    corners = np.array([[-0.055, -0.022], [0.055, -0.022], [0.055, 0.022], [-0.055, 0.022]])
    c, s = math.cos(angle), math.sin(angle)
    return Polygon(corners @ np.array([[c, s], [-s, c]]) + (x, y), closed=True, facecolor=INK, zorder=9)


def _draw_legend(axes: Axes, snapshot: StepSnapshot) -> None:
    def dot(color: str, label: str, **options: Any) -> Line2D:
        return Line2D([], [], marker="o", linestyle="none", color=color, label=label, **{"markersize": 4, **options})

    def stroke(color: str, label: str, **options: Any) -> Line2D:
        return Line2D([], [], color=color, label=label, **options)

    bent = snapshot.params["minimum_curvature"]["bend_passes"] > 0
    entries = [
        dot(LEFT, "left wall"),
        dot(RIGHT, "right wall"),
        dot(DROPPED, "dropped"),
        dot(INK, "carried over", markerfacecolor="none", markersize=5),
        stroke(PAIR, "width pairs", linewidth=0.9),
        stroke(LINE, "centerline", linewidth=1.2, marker="o", markersize=3),
        stroke(
            INK,
            "minimum-curvature control points" if bent else "smoothed, joined to the car",
            linewidth=0.9,
            linestyle=(0, (4, 2)),
        ),
        dot(INK, "simplified (Opheim)", markerfacecolor=PAPER, markersize=5.5),
        stroke("#1ae4b6", "spline, by speed", linewidth=4),
        dot(PATH, "lookahead point", markerfacecolor="none", markersize=8, markeredgewidth=1.8),
    ]
    if snapshot.walls:
        entries.append(stroke(WALL, "true walls", linewidth=4))
    legend_below(axes, entries)


def legend_below(axes: Axes, entries: list[Line2D]) -> None:
    """Draws the legend below a scene."""
    axes.legend(
        handles=entries,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.025),
        ncols=6,
        frameon=False,
        fontsize=9.5,
        labelcolor=INK,
        handlelength=1.8,
        columnspacing=1.6,
    )


def _draw_terms(axes: Axes, snapshot: StepSnapshot) -> None:
    """Draws the four terms of the steering angle and their sum, in degrees."""
    terms = snapshot.trace["steering"]
    limit = math.degrees(snapshot.params["car"]["steering_limit"])
    errors = {
        "heading": f"Δψ {signed(math.degrees(terms['heading_error']), 1)}°",
        "cross_track": f"Δd {signed(terms['cross_track_error'], 2)} m",
        "yaw_rate": f"Δr {signed(math.degrees(terms['yaw_rate_error']), 0)}°/s",
        "steering": f"Δδ {signed(math.degrees(terms['steering_change']), 1)}°",
    }
    values = [math.degrees(terms[key]) for key, _, _ in TERMS] + [math.degrees(terms["steering_angle"])]
    reach = max(6.0, *(abs(value) for value in values)) * 1.6
    for row, value in enumerate(values):
        last = row == len(values) - 1
        axes.barh(row, value, height=0.58, color=INK if last else PATH, alpha=0.9, zorder=3)
        shift = 0.02 * reach * (1 if value >= 0 else -1)
        # The axis runs left, as the car steers: text beyond a positive bar ends where the bar does.
        side = "right" if value >= 0 else "left"
        axes.text(value + shift, row, f"{signed(value, 2)}°", va="center", ha=side, fontsize=10, color=INK, zorder=4)
    axes.axhline(len(values) - 1.5, color="#d5dade", linewidth=0.8)
    axes.axvline(0.0, color=INK, linewidth=0.8, zorder=2)
    for sign in (-1, 1) if limit < reach else ():
        axes.axvline(sign * limit, color=BAD, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1)
    axes.set_xlim(reach, -reach)
    axes.set_ylim(len(values) - 0.4, -0.6)
    labels = [f"{name}\n{errors[key]}" for key, name, _ in TERMS] + ["sum"]
    axes.set_yticks(range(len(values)), labels, fontsize=9.5, color=INK)
    axes.tick_params(length=0, labelsize=9.5, colors=INK)
    axes.set_xticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    title = f"steering angle: left ← → right   L {terms['lookahead']:.2f} m   k_ang {terms['k_ang']:.2f}"
    axes.set_title(title, fontsize=10.5, color=INK, loc="right", pad=8)


def _draw_profile(axes: Axes, snapshot: StepSnapshot) -> None:
    """Draws the planned speed along the path with its limits."""
    path = snapshot.trace["path"]
    limits = snapshot.params["velocity_profile"]
    axes.set_title("speed along the path [m/s]", fontsize=11, color=INK, loc="left", pad=8)
    axes.tick_params(colors=INK, labelsize=9.5)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(FAINT)
    axes.set_xlabel("distance ahead of the front axle [m]", fontsize=9.5, color=INK)
    if len(path["s"]) < 2:
        axes.text(0.5, 0.5, "no path", transform=axes.transAxes, ha="center", fontsize=14, color=BAD)
        return
    s = path["s"] - path["s"][snapshot.trace["nearest"]]
    grip = np.sqrt(limits["a_y_max"] / np.maximum(np.abs(path["curvature"]), 1e-4))
    top = max(float(path["velocity"].max()), snapshot.speed, limits["v_min"]) * 1.25
    axes.fill_between(s, grip, 1e3, color="#f6dedc", linewidth=0, zorder=1)
    axes.plot(s, grip, color=BAD, linewidth=1.0, zorder=2, label="√(a_y / |κ|)")
    for name in ("v_min", "v_max"):
        if limits[name] < top:
            axes.axhline(limits[name], color=FAINT, linewidth=0.9, linestyle=(0, (4, 2)), zorder=2)
            beside = axes.get_yaxis_transform()
            axes.text(0.0, limits[name], f" {name}", fontsize=9, color=INK, va="bottom", transform=beside)
    colored_line(axes, s, path["velocity"], path["velocity"], 3.5, zorder=4)
    axes.plot(0.0, snapshot.speed, "o", color=INK, markersize=6, zorder=5)
    axes.annotate("measured", (float(s[0]), snapshot.speed), textcoords="offset points", xytext=(4, -12), fontsize=9,
                  color=INK)  # fmt: skip
    preview = max(snapshot.speed, 0.0) * limits["preview_time"]
    command = snapshot.trace["result"][0]
    axes.plot(preview, command, "D", color=PATH, markersize=6, zorder=6)
    axes.annotate("command", (preview, command), textcoords="offset points", xytext=(8, -12), fontsize=9, color=PATH)
    ahead = snapshot.trace["lookahead"]["s"] - path["s"][snapshot.trace["nearest"]]
    axes.axvline(ahead, color=PATH, linewidth=0.9, linestyle=(0, (2, 2)), zorder=2)
    axes.set_xlim(float(s[0]), float(s[-1]))
    axes.set_ylim(0.0, top)
    axes.legend(loc="lower right", frameon=False, fontsize=9, labelcolor=INK)
