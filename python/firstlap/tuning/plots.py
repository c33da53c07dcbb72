"""Plots of a tuning, like the paper's: parameters and lap time by setting, driven lines, the Pareto front."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from firstlap.config.parameters import Field, Value
from firstlap.plots.colors import BAD, FAINT, INK, LEFT, RIGHT
from firstlap.plots.primitives import bare, colored_line, draw_road, draw_start, draw_walls, new_figure
from firstlap.sim.race import RaceResult
from firstlap.tracks.track import Track
from firstlap.tuning.selection import pareto_front
from firstlap.tuning.settings import Setting
from firstlap.tuning.study import Trial

MOTION = ("velocity_profile", "speed")
"""Sections of a setup that determine the speed; the others determine the path."""


def embedded(figure: Figure, words: str) -> str:
    """An HTML image with embedded data."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="{words}" src="data:image/png;base64,{data}">'


def draw_parameters(
    fields: Sequence[Field],
    settings: Sequence[Setting],
    published: Mapping[str, Mapping[int, Value]] | None = None,
) -> Figure:
    """One small axes per parameter, its value over the settings; published: values by name and setting."""
    columns = 4
    rows = -(-len(fields) // columns)
    figure = new_figure(11.0, 2.1 * rows + 0.5)
    for index, field in enumerate(fields):
        axes = figure.add_subplot(rows, columns, index + 1)
        values = [float(setting.given.get((field.section, field.name), field.default)) for setting in settings]
        _by_setting(axes, values, settings)
        printed = (published or {}).get(field.name, {})
        axes.plot(list(printed), list(printed.values()), "s", color=RIGHT, markersize=10, fillstyle="none")
        unit = f" [{field.unit}]" if field.unit else ""
        axes.set_title(f"{field.name}{unit}".replace("^2", "²"), fontsize=9, color=INK)
        last = index + columns >= len(fields)
        _label_settings(axes, settings if last else [])
    figure.tight_layout()
    return figure


def draw_laps(settings: Sequence[Setting], published: Mapping[int, float] | None = None) -> Figure:
    """Lap time by setting; published: published lap times [s] by index of the setting."""
    figure = new_figure(11.0, 3.6)
    axes = figure.add_subplot()
    laps = [float("nan") if setting.lap is None else setting.lap for setting in settings]
    _by_setting(axes, laps, settings, label="ours" if published else None)
    for place, lap in enumerate(laps):
        if np.isfinite(lap):
            beside = (0, -16) if published else (0, 8)  # the published laps are usually the longer ones
            axes.annotate(
                f"{lap:.2f}", (place, lap), xytext=beside, textcoords="offset points", ha="center", fontsize=9
            )
    if published:
        shown = {place: lap for place, lap in published.items() if place < len(settings)}
        axes.plot(list(shown), list(shown.values()), "s--", color=RIGHT, label="the paper's")
        axes.legend(frameon=False)
    axes.margins(y=0.25)
    axes.set_ylabel("lap [s]")
    _label_settings(axes, settings)
    figure.tight_layout()
    return figure


def _by_setting(axes: Axes, values: Sequence[float], settings: Sequence[Setting], label: str | None = None) -> None:
    axes.plot(range(len(values)), values, "-", color=LEFT, linewidth=1.4, label=label)
    for place, (value, setting) in enumerate(zip(values, settings, strict=True)):
        axes.plot(place, value, "o" if setting.holds else "X", color=LEFT if setting.holds else BAD, markersize=6)
    axes.grid(visible=True, color=FAINT, alpha=0.3, linewidth=0.6)
    axes.tick_params(colors=INK, labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _label_settings(axes: Axes, settings: Sequence[Setting]) -> None:
    axes.set_xticks(range(len(settings)))
    axes.set_xticklabels([setting.label for setting in settings], fontsize=8, rotation=30, ha="right")


def draw_front(trials: Sequence[Trial], marked: Mapping[str, tuple[float, float]], margin: float) -> Figure:
    """Lap time against smallest clearance of every trial, with the Pareto front.

    marked: the selected setups, their lap [s] and clearance [m] on the check seeds.
    """
    figure = new_figure(11.0, 4.6)
    axes = figure.add_subplot()
    whole = [t for t in trials if t.verdict.lap and not t.verdict.failed and not t.verdict.ended]
    failed = [t for t in trials if t.verdict.lap and t.verdict.failed]
    early = [t for t in trials if t.verdict.lap and not t.verdict.failed and t.verdict.ended]
    for some, color, words in (
        (early, FAINT, "ended early"),
        (whole, LEFT, "raced all"),
        (failed, BAD, "failed a race"),
    ):
        laps = [t.verdict.lap or np.nan for t in some]
        axes.plot(
            laps, [t.verdict.clearance for t in some], ".", color=color, alpha=0.6, label=f"{words} ({len(some)})"
        )
    best = pareto_front(trials)
    axes.plot(
        [t.verdict.lap or np.nan for t in best], [t.verdict.clearance for t in best], "-", color=LEFT, label="the front"
    )
    axes.axhline(margin, color=BAD, linestyle=":", linewidth=1.2)
    axes.annotate("margin", (1.0, margin), xycoords=("axes fraction", "data"), ha="right", va="bottom", color=BAD)
    for (name, (lap, clearance)), marker in zip(marked.items(), "*Dsv", strict=False):
        axes.plot(lap, clearance, marker, color=RIGHT, markersize=13, markeredgecolor=INK, label=f"{name}, check seeds")
    axes.set_xlabel("lap [s]")
    axes.set_ylabel("smallest clearance [m]")
    axes.legend(frameon=False, fontsize=9)
    axes.grid(visible=True, color=FAINT, alpha=0.3, linewidth=0.6)
    figure.tight_layout()
    return figure


def draw_importance(shares: Mapping[str, float]) -> Figure:
    """Importance of the parameters as bars, the largest at the top."""
    names = [name.rpartition(".")[2] for name in shares][::-1]
    figure = new_figure(11.0, 0.28 * len(names) + 1.0)
    axes = figure.add_subplot()
    axes.barh(names, list(shares.values())[::-1], color=LEFT)
    axes.set_xlabel("relative importance")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(labelsize=9)
    figure.tight_layout()
    return figure


def draw_search(trials: Sequence[Trial]) -> Figure:
    """Lap time of every trial in the order of the search, and the best reliable one so far."""
    figure = new_figure(11.0, 3.4)
    axes = figure.add_subplot()
    for held, color, words in ((True, LEFT, "holds"), (False, FAINT, "not reliable, or stopped early")):
        some = [t for t in trials if t.verdict.lap and t.verdict.holds == held]
        axes.plot([t.number for t in some], [t.verdict.lap or np.nan for t in some], ".", color=color, label=words)
    best = np.minimum.accumulate([t.cost if t.verdict.holds else np.inf for t in trials]) if trials else np.array([])
    axes.plot([t.number for t in trials], np.where(np.isfinite(best), best, np.nan), color=RIGHT, label="best reliable")
    axes.set_xlabel("trial")
    axes.set_ylabel("lap [s]")
    axes.legend(frameon=False, fontsize=9)
    figure.tight_layout()
    return figure


def draw_lines(track: Track, compared: RaceResult, tuned: RaceResult) -> Figure:
    """A flying lap of each setup on the track: the first in gray, the second colored by its speed."""
    corners = np.vstack(track.walls)
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    height = float(np.clip(11.0 * (high[1] - low[1]) / (high[0] - low[0]), 4.0, 11.0))
    figure = new_figure(11.0, height)
    axes = figure.add_axes((0.02, 0.02, 0.9, 0.96))
    bare(axes)
    draw_road(axes, track)
    draw_walls(axes, track, width=1.1)
    draw_start(axes, track)
    gray = _last_lap(compared)
    axes.plot(gray["x"], gray["y"], "--", color=INK, linewidth=1.2, zorder=4, label=compared.setup.name)
    line = _last_lap(tuned)
    colored = colored_line(axes, line["x"], line["y"], line["speed"], 2.4, zorder=5)
    figure.colorbar(colored, ax=axes, shrink=0.6, label="speed [m/s]", pad=0.01)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.legend(frameon=False, loc="upper right")
    return figure


def _last_lap(result: RaceResult) -> dict[str, np.ndarray]:
    """The path's columns of the last complete lap; the whole path if there is none."""
    end = sum(lap.time for lap in result.laps) or float("inf")
    begin = end - result.laps[-1].time if result.laps else 0.0
    kept = (result.path["time"] >= begin) & (result.path["time"] <= end)
    return {name: result.path[name][kept] for name in ("x", "y", "speed")}
