"""Plots a race over time: measured, estimated and true speed, their errors, gyro bias, wheel slip and side slip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from firstlap.evaluation.estimation.drive import Drive
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, PATH, ROAD
from firstlap.plots.primitives import new_figure, save, write

WIDTH, HEIGHT = 11.0, 9.4
RAW, ESTIMATE = LEFT, PATH
MAX_ERROR = 1.0
"""[m/s] Larger errors are cut off in the plot: while wheels are locked, the error is the whole speed."""

Floats = npt.NDArray[np.float64]


def plot_drive(drive: Drive, title: str, path: str | Path) -> None:
    """Writes the plot. Raises InputError."""
    figure = new_figure(WIDTH, HEIGHT)
    write(figure, 0.07, 0.965, title, fontsize=15, fontweight="bold")
    panels = [figure.add_axes((0.07, 0.055 + 0.178 * (4 - row), 0.9, 0.128)) for row in range(5)]
    for panel in panels:
        _dress(panel, drive, last=panel is panels[-1])
    _draw_speed(panels[0], drive)
    _draw_error(panels[1], drive)
    _draw_bias(panels[2], drive)
    _draw_slip(panels[3], drive)
    _draw_side_slip(panels[4], drive)
    save(figure, path)


def _dress(axes: Axes, drive: Drive, last: bool) -> None:
    axes.set_xlim(0.0, drive.times[-1])
    axes.grid(color=ROAD, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=9, labelbottom=last)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(FAINT)
    if last:
        axes.set_xlabel("seconds", fontsize=10, color=INK)


def _name(axes: Axes, text: str) -> None:
    axes.set_title(text, fontsize=10.5, color=INK, loc="left", pad=5)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, frameon=False, fontsize=9, labelcolor=INK,
                    borderaxespad=0.1, handlelength=1.4)  # fmt: skip


def _draw_speed(axes: Axes, drive: Drive) -> None:
    axes.plot(drive.times, drive.readings["wheel_speed"], color=RAW, linewidth=0.9, label="wheels")
    axes.plot(drive.times, drive.truth["speed"], color=INK, linewidth=2.4, alpha=0.35, label="true")
    axes.plot(drive.times, drive.estimates["speed"], color=ESTIMATE, linewidth=1.0, label="estimate")
    _name(axes, "speed [m/s]")


def _draw_error(axes: Axes, drive: Drive) -> None:
    for values, color, label in (
        (drive.readings["wheel_speed"], RAW, "wheels"),
        (drive.estimates["speed"], ESTIMATE, "estimate"),
    ):
        error = np.clip(values - drive.truth["speed"], -MAX_ERROR, MAX_ERROR)
        axes.plot(drive.times, error, color=color, linewidth=0.9, label=label)
    rejected = drive.estimates["wheels_rejected"] > 0.0
    marks = np.full(int(rejected.sum()), 0.95 * MAX_ERROR)
    axes.plot(drive.times[rejected], marks, "|", color=BAD, label="wheels rejected")
    _name(axes, f"error of the speed [m/s], cut off at {MAX_ERROR:g}")


def _draw_bias(axes: Axes, drive: Drive) -> None:
    true = drive.case.options.get("sensors.yaw_rate_bias", 0.0)
    axes.axhline(true, color=INK, linewidth=2.4, alpha=0.35, label="true")
    axes.plot(drive.times, drive.estimates["yaw_rate_bias"], color=ESTIMATE, linewidth=1.0, label="estimate")
    _name(axes, "bias of the gyro [rad/s]")


def _draw_slip(axes: Axes, drive: Drive) -> None:
    true = drive.case.options.get("sensors.wheel_slip", 0.0)
    axes.axhline(100.0 * true, color=INK, linewidth=2.4, alpha=0.35, label="true")
    axes.plot(drive.times, 100.0 * drive.estimates["wheel_slip"], color=ESTIMATE, linewidth=1.0, label="estimate")
    _name(axes, "slip of the wheels [% per m/s²]")


def _draw_side_slip(axes: Axes, drive: Drive) -> None:
    axes.plot(drive.times, drive.truth["lateral_speed"], color=INK, linewidth=2.4, alpha=0.35, label="true")
    axes.plot(drive.times, drive.estimates["lateral_speed"], color=ESTIMATE, linewidth=1.0, label="estimate")
    _name(axes, "side slip of the rear axle [m/s]")
