"""Plots robustness curves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from firstlap.common.text import short_name
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, RIGHT
from firstlap.plots.primitives import new_figure, save

COLUMNS = 4
GOOD = "#2e7d32"


def plot_robustness(found: dict[str, Any], path: str | Path) -> None:
    """Writes one panel per sweep: rates above, laps below. found: as in --json. Raises InputError."""
    sweeps = found["sweeps"]
    columns = min(COLUMNS, len(sweeps))
    rows = math.ceil(len(sweeps) / columns)
    width, height = 4.1 * columns + 0.3, 4.3 * rows + 1.1
    figure = new_figure(width, height)
    figure.text(0.3 / width, 1.0 - 0.35 / height, f"Robustness of {found['setup']}", fontsize=17, fontweight="bold",
                color=INK, va="center", parse_math=False)  # fmt: skip
    names = ", ".join(short_name(name) for name in sweeps[0]["tracks"])
    details = f"car {found['car']}, {found['laps']} laps, seeds 1 to {found['seeds']}"
    details += f"{', both directions' if found['both'] else ''}: {names}"
    figure.text(0.3 / width, 1.0 - 0.68 / height, details, fontsize=10, color=INK, va="center", parse_math=False)
    for i, sweep in enumerate(map(_in_order, sweeps)):
        left = (4.1 * (i % columns) + 0.75) / width
        bottom = 1.0 - (0.95 + 4.3 * (i // columns + 1) - 0.7) / height
        upper = figure.add_axes((left, bottom + 1.15 / height, 3.2 / width, 2.2 / height))
        lower = figure.add_axes((left, bottom, 3.2 / width, 0.95 / height))
        _draw_rates(upper, sweep)
        if sweep["name"] == "obstacle":
            _draw_shares(lower, sweep)
        else:
            _draw_laps(lower, sweep)
        unit = f" [{sweep['unit']}]" if sweep["unit"] else ""
        lower.set_xlabel(sweep["title"] + unit, fontsize=9, color=INK)
    save(figure, path)


def _in_order(sweep: dict[str, Any]) -> dict[str, Any]:
    """The sweep with its values sorted for the axis."""
    values = [point["value"] for point in sweep["points"]]
    if values in (sorted(values), sorted(values, reverse=True)):
        return sweep
    tracks = {name: sorted(points, key=_value) for name, points in sweep["tracks"].items()}
    return {**sweep, "points": sorted(sweep["points"], key=_value), "tracks": tracks}


def _value(point: dict[str, Any]) -> float:
    return float(point["value"])


def _prepare(axes: Axes, sweep: dict[str, Any]) -> list[float]:
    values = [point["value"] for point in sweep["points"]]
    axes.grid(color="#edf0f2", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_color("#d5dade")
    axes.set_xlim(values[0], values[-1])
    return values


def _draw_rates(axes: Axes, sweep: dict[str, Any]) -> None:
    values = _prepare(axes, sweep)
    for points in sweep["tracks"].values():
        axes.plot(values, [_percent(point["contact_free"]) for point in points], color=FAINT, linewidth=0.7, alpha=0.7)
    points = sweep["points"]
    done = "passed or stopped" if _box(sweep) else "finished"
    finished = [_percent(point["finished"]) for point in points]
    free = [_percent(point["contact_free"]) for point in points]
    axes.plot(values, free, color=BAD, linewidth=2.4, marker="o", markersize=5, label="contact-free")
    axes.plot(values, finished, color=LEFT, linewidth=1.4, linestyle="dashed", marker="s", markersize=2.5, label=done)
    axes.plot([], [], color=FAINT, linewidth=0.7, label="contact-free, each track")
    axes.set_ylim(-4, 104)
    axes.set_ylabel("share of races [%]", fontsize=9, color=INK)
    axes.set_xticklabels([])
    axes.set_title(sweep["name"].replace("_", " "), fontsize=12, fontweight="bold", color=INK, loc="left")
    axes.legend(fontsize=7.5, loc="lower left", frameon=False)


def _draw_laps(axes: Axes, sweep: dict[str, Any]) -> None:
    values = _prepare(axes, sweep)
    for points in sweep["tracks"].values():
        axes.plot(values, [_number(point["lap_ratio"]) for point in points], color=FAINT, linewidth=0.7, alpha=0.7)
    ratios = [_number(point["lap_ratio"]) for point in sweep["points"]]
    axes.plot(values, ratios, color=RIGHT, linewidth=2.0, marker="o", markersize=3.5)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.97), max(high, 1.06))
    axes.set_ylabel("lap, relative", fontsize=9, color=INK)


def _draw_shares(axes: Axes, sweep: dict[str, Any]) -> None:
    values = _prepare(axes, sweep)
    for name, color in (("passed", GOOD), ("stopped", RIGHT)):
        axes.plot(values, [_percent(point[name]) for point in sweep["points"]], color=color, linewidth=2.0,
                  marker="o", markersize=3.5, label=name)  # fmt: skip
    axes.set_ylim(-4, 104)
    axes.set_ylabel("share [%]", fontsize=9, color=INK)
    axes.legend(fontsize=7.5, frameon=False, loc="center right")


def _box(sweep: dict[str, Any]) -> bool:
    return bool(sweep["name"] == "obstacle")


def _percent(rate: float | None) -> float:
    return math.nan if rate is None else 100.0 * rate


def _number(value: float | None) -> float:
    return math.nan if value is None else value
