"""Plots a replay: commands, width, statuses and jumps over time, and the driven path if known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from firstlap.common.text import printable
from firstlap.evaluation.replay.continuity import BIG_JUMP, JUMP_AHEAD
from firstlap.evaluation.replay.replay import Replay, ReplayResult
from firstlap.plots.colors import BAD, FAINT, INK, LEFT
from firstlap.plots.primitives import bare, colored_line, new_figure, save, write
from firstlap.recordings.recording import LONGEST_PAUSE
from firstlap.recordings.step_log import STATUSES

Floats = npt.NDArray[np.float64]

PLANNED, OTHER, RECORDED = "#6a1b9a", "#00897b", "#9aa4af"
STATUS_COLORS = dict(zip(STATUSES, ("#c8e6c9", "#ffe082", BAD, "#f48fb1", "#5d4037", "#212121"), strict=True))
SIDE_COLORS = {"both": "#c8e6c9", "one": "#ffe082", "none": BAD}
WIDTH, LEFT_EDGE, WIDE, NARROW = 16.0, 0.06, 0.92, 0.62


def plot_replay(replay: Replay, path: str | Path) -> None:
    """Writes the plot. Raises InputError."""
    rows = 6 if replay.against is not None else 4
    height = 1.9 + 1.75 * rows
    figure = new_figure(WIDTH, height)
    poses = replay.recording.poses
    width = WIDE if poses is None else NARROW
    times = replay.recording.stamps
    step = (height - 1.95) / rows
    panels = [
        figure.add_axes((LEFT_EDGE, (0.75 + step * (rows - 1 - i)) / height, width, 0.76 * step / height))
        for i in range(rows)
    ]
    for panel in panels:
        _set_axes(panel, times, last=panel is panels[-1])
    _write_head(figure, replay, height)
    _draw_commands(panels[0], panels[1], replay)
    if replay.against is not None:
        _draw_difference(panels[2], panels[3], replay.driven, replay.against, times)
    _draw_width(panels[-2], replay)
    _draw_jump(panels[-1], replay)
    if poses is not None:
        _draw_path(figure, replay, height)
    save(figure, path)


def _set_axes(axes: Axes, times: Floats, last: bool) -> None:
    axes.set_xlim(times[0], max(times[-1], times[0] + 1e-3))
    axes.grid(color="#edf0f2", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=9.5, labelbottom=last)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(FAINT)
    if last:
        axes.set_xlabel("seconds", fontsize=10.5, color=INK)


def _broken(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The line with breaks at gaps of the recording."""
    after = np.flatnonzero(np.diff(times) > LONGEST_PAUSE) + 1
    return np.insert(times, after, times[after - 1]), np.insert(values, after, np.nan)


def _title(axes: Axes, text: str) -> None:
    axes.set_title(printable(text), fontsize=11, color=INK, loc="left", pad=6, parse_math=False)


def _legend(axes: Axes) -> None:
    legend = axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=9, frameon=False, fontsize=9,
                         labelcolor=INK, borderaxespad=0.1, handlelength=1.2, columnspacing=1.2)  # fmt: skip
    for label in legend.get_texts():
        label.set_parse_math(False)


def _write_head(figure: Figure, replay: Replay, height: float) -> None:
    recording, found = replay.recording, replay.to_dict()
    write(figure, LEFT_EDGE, 1.0 - 0.42 / height, recording.name, fontsize=19, fontweight="bold")
    other = f" against {replay.against.setup.name}" if replay.against else ""
    statuses = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in found["statuses"].items())
    details = (
        f"{found['scans']} scans, {found['seconds']:.1f} s   ·   setup {replay.driven.setup.name}{other}, car "
        f"{replay.car.name}   ·   {statuses}   ·   speed from {recording.sources['speed']}"
    )
    write(figure, LEFT_EDGE, 1.0 - 0.82 / height, details, fontsize=10.5)


def _draw_commands(speeds: Axes, angles: Axes, replay: Replay) -> None:
    recording, driven, other = replay.recording, replay.driven, replay.against
    times = recording.stamps
    _title(speeds, "commanded speed [m/s]")
    _title(angles, "commanded steering angle, left positive [°]")
    commands = recording.commands
    if commands is not None:
        recorded: dict[str, Any] = {"color": RECORDED, "linewidth": 2.2, "label": "recorded"}
        speeds.plot(*_broken(times, commands.speed), **recorded)
        angles.plot(*_broken(times, np.degrees(commands.steering_angle)), **recorded)
    speeds.plot(
        *_broken(times, recording.speed), color=INK, linewidth=0.9, linestyle=(0, (4, 2)), label="the car's speed"
    )
    for one, color in ((other, OTHER), (driven, PLANNED)):
        if one is None:
            continue
        style: dict[str, Any] = {"color": color, "linewidth": 1.2, "label": printable(one.setup.name)}
        speeds.plot(*_broken(times, one.speed), **style)
        angles.plot(*_broken(times, np.degrees(one.steering_angle)), **style)
    speeds.set_ylim(bottom=min(0.0, float(recording.speed.min())))
    for axes in (speeds, angles):
        _legend(axes)


def _draw_difference(speeds: Axes, angles: Axes, driven: ReplayResult, other: ReplayResult, times: Floats) -> None:
    names = f"{driven.setup.name} minus {other.setup.name}"
    rows = (
        (speeds, driven.speed - other.speed, f"difference of speed, {names} [m/s]"),
        (
            angles,
            np.degrees(driven.steering_angle - other.steering_angle),
            f"difference of steering angle, {names} [°]",
        ),
    )
    for axes, values, title in rows:
        _title(axes, title)
        axes.axhline(0.0, color=FAINT, linewidth=0.9)
        x, y = _broken(times, values)
        axes.fill_between(x, np.maximum(y, 0.0), 0.0, color=PLANNED, linewidth=0, alpha=0.55)
        axes.fill_between(x, np.minimum(y, 0.0), 0.0, color=OTHER, linewidth=0, alpha=0.55)


def _draw_width(axes: Axes, replay: Replay) -> None:
    driven, times = replay.driven, replay.recording.stamps
    if not len(driven.width):
        _title(axes, f"status; driver {driven.setup.driver} reports no perception")
        _ribbon(axes, times, driven.status, list(STATUS_COLORS.values()), (0.0, 1.0))
        axes.set_yticks([])
        return
    _title(axes, "track width [m]; above: status, below: visible walls")
    axes.plot(times, driven.width_seen, ".", color=LEFT, markersize=2.5, label="seen")
    axes.plot(*_broken(times, driven.width), color=INK, linewidth=1.2, label="remembered")
    top = 1.3 * max(float(np.nanmax(np.append(driven.width_seen, driven.width.max()))), 1.0)
    axes.set_ylim(0.0, top)
    _ribbon(axes, times, driven.status, list(STATUS_COLORS.values()), (0.92 * top, top))
    sides = np.where(driven.left & driven.right, 0, np.where(driven.left | driven.right, 1, 2))
    _ribbon(axes, times, sides, list(SIDE_COLORS.values()), (0.0, 0.08 * top))
    for name in [STATUSES[i] for i in sorted(set(driven.status.tolist()))]:
        axes.plot([], [], "s", color=STATUS_COLORS[name], label=name.replace("_", " "))
    _legend(axes)


def _ribbon(axes: Axes, times: Floats, codes: npt.NDArray[Any], colors: list[str], span: tuple[float, float]) -> None:
    """A strip of colors over time."""
    if len(times) < 2:
        return
    edges = np.concatenate([[times[0]], 0.5 * (times[1:] + times[:-1]), [times[-1]]])
    axes.pcolormesh(edges, span, codes[None, :], cmap=ListedColormap(colors), vmin=-0.5, vmax=len(colors) - 0.5)


def _draw_jump(axes: Axes, replay: Replay) -> None:
    driven, times = replay.driven, replay.recording.stamps
    _title(axes, f"jump of the path {JUMP_AHEAD:g} m ahead [m]; marked: a wall changed its side")
    if not len(driven.jump):
        return
    finite = driven.jump[np.isfinite(driven.jump)]
    top = max(2.0 * BIG_JUMP, float(np.percentile(finite, 99.5)) if len(finite) else 0.0)
    axes.vlines(times, 0.0, np.minimum(np.nan_to_num(driven.jump), top), color=PLANNED, linewidth=0.8)
    axes.axhline(BIG_JUMP, color=BAD, linewidth=0.9, linestyle=(0, (4, 2)))
    axes.plot(times[driven.changed], np.full(int(driven.changed.sum()), 0.97 * top), "|", color=BAD, markersize=9)
    axes.set_ylim(0.0, top)


def _draw_path(figure: Figure, replay: Replay, height: float) -> None:
    recording, driven = replay.recording, replay.driven
    axes = figure.add_axes((0.71, 0.75 / height, 0.27, 1.0 - 2.1 / height))
    bare(axes)
    assert recording.poses is not None
    x, y = recording.poses[:, 0], recording.poses[:, 1]
    pieces = np.flatnonzero(np.hypot(np.diff(x), np.diff(y)) > 1.0) + 1
    for part in np.split(np.arange(len(x)), pieces):
        if len(part) > 1:
            line = colored_line(axes, x[part], y[part], driven.speed[part], 2.6)
            line.set_clim(float(driven.speed.min()), float(driven.speed.max()))
    bad = driven.status != STATUSES.index("ok")
    axes.plot(x[bad], y[bad], "x", color=BAD, markersize=5, label="not ok")
    big = np.flatnonzero(np.nan_to_num(driven.jump) > BIG_JUMP)
    axes.plot(x[big], y[big], "o", markerfacecolor="none", markeredgecolor=INK, markersize=5, label="path jumps")
    _title(
        axes,
        f"driven path ({recording.frame or 'no frame'}), colored by planned speed\n"
        f"{driven.speed.min():.1f} to {driven.speed.max():.1f} m/s",
    )
    axes.legend(loc="lower left", frameon=False, fontsize=9.5, labelcolor=INK)
    reach = 0.5 * max(np.ptp(x), np.ptp(y), 1.0) * math.sqrt(1.1)
    axes.set_xlim(0.5 * (x.min() + x.max()) - reach, 0.5 * (x.min() + x.max()) + reach)
    axes.set_ylim(0.5 * (y.min() + y.max()) - reach, 0.5 * (y.min() + y.max()) + reach)
