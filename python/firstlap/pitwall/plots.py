"""Time plots of speed, steering, clearance and step time."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import viser
from viser import uplot

from firstlap.pitwall.frame import Frame
from firstlap.pitwall.scene import commanded
from firstlap.pitwall.shapes import column_in, number_in
from firstlap.plots.colors import BAD, GOOD, INK, LEFT, PATH, RIGHT

SECONDS = 10.0
"""[s] Length of the time axis."""
STEPS = 201
"""Number of samples on the time axis."""
KEPT = 512
"""Number of frames kept; more than arrive in that time."""
HEIGHT = 118
"""[pixels] Height of a plot."""
FONT = "11px sans-serif"
Values = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """One curve of a plot. names: name by driver; "" is the default. A driver without a name has no such curve."""

    names: dict[str, str]
    color: str
    value: Callable[[Frame], float]
    width: float = 1.5

    def name(self, driver: str) -> str | None:
        """The name for a driver; None if it has no such curve."""
        return self.names.get(driver, self.names.get(""))


@dataclass(frozen=True)
class Plot:
    """digits: decimals of its numbers. lowest: lower end of the axis; None: from the data."""

    title: str
    unit: str
    digits: int
    curves: tuple[Curve, ...]
    lowest: float | None = None


def _planned_here(frame: Frame) -> float:
    """Planned speed [m/s] at the path point nearest the front axle, or at the start of the plan."""
    speeds = column_in(frame.trace, "path", "velocity")
    if len(speeds):
        nearest = number_in(frame.trace, "nearest")
        return float(speeds[min(int(nearest), len(speeds) - 1)]) if math.isfinite(nearest) else math.nan
    plan = column_in(frame.trace, "plan_speed")
    return float(plan[0]) if len(plan) else math.nan


def _degrees(*names: str) -> Callable[[Frame], float]:
    """The first of these values that the trace has, in degrees."""

    def value(frame: Frame) -> float:
        for name in names:
            found = number_in(frame.trace, *name.split("."))
            if math.isfinite(found):
                return math.degrees(found)
        return math.nan

    return value


def _free(frame: Frame) -> float:
    """Free distance [m] around or ahead of the path, according to the driver."""
    for name in ("clearance", "arc_free", "aim_free", "free"):
        found = number_in(frame.trace, name)
        if math.isfinite(found):
            return found
    sides = [column_in(frame.trace, side) for side in ("left", "right")]
    return min((float(side.min()) for side in sides if len(side)), default=math.nan)


def _so_far(frame: Frame) -> float:
    return math.nan if frame.clearance is None else frame.clearance


_SUM = _degrees("steering.steering_angle", "wanted")
PLOTS = (
    Plot(
        "speed",
        "m/s",
        2,
        (
            Curve({"local": "planned", "global": "planned"}, RIGHT, _planned_here),
            Curve({"": "commanded"}, PATH, lambda frame: commanded(frame)[0]),
            Curve({"": "measured"}, INK, lambda frame: frame.speed, 2.0),
        ),
        lowest=0.0,
    ),
    Plot(
        "steering angle",
        "°",
        1,
        (
            Curve({"local": "heading", "pid": "P"}, LEFT, _degrees("steering.heading", "p_term")),
            Curve({"local": "cross-track", "pid": "I"}, RIGHT, _degrees("steering.cross_track", "i_term")),
            Curve({"local": "yaw rate", "pid": "D"}, GOOD, _degrees("steering.yaw_rate", "d_term")),
            Curve({"local": "change"}, BAD, _degrees("steering.steering")),
            Curve({"local": "sum", "gap": "wanted", "disparity": "wanted"}, PATH, _SUM, 2.0),
            Curve({"": "commanded"}, INK, lambda frame: math.degrees(commanded(frame)[1])),
        ),
    ),
    Plot(
        "clearance",
        "m",
        2,
        (
            Curve({"": "minimum of the lap"}, BAD, _so_far),
            Curve({"local": "path to wall", "global": "plan to wall", "": "free ahead"}, LEFT, _free),
        ),
        lowest=0.0,
    ),
    Plot("step time", "µs", 0, (Curve({"": "driver"}, INK, lambda frame: frame.step_us),), lowest=0.0),
)


class History:
    """The values of all curves in the last frames, with their times."""

    def __init__(self) -> None:
        self._curves = [curve for plot in PLOTS for curve in plot.curves]
        self._rows = np.full((KEPT, 1 + len(self._curves)), np.nan)
        self._count = 0
        self._driver = ""

    def add(self, frame: Frame) -> None:
        """Adds a frame. Starts over if time decreases or jumps by more than the length of the axis."""
        last = self._rows[-1, 0]
        if self._count and (not 0.0 <= frame.time - last < SECONDS or frame.driver != self._driver):
            self._count = 0
        if self._count and frame.time == last:
            self._count -= 1
        else:
            self._rows[:-1] = self._rows[1:]
        self._driver = frame.driver
        values = [curve.value(frame) if curve.name(frame.driver) else math.nan for curve in self._curves]
        self._rows[-1] = [frame.time, *values]
        self._count = min(self._count + 1, KEPT)

    def sampled(self) -> tuple[Values, Values]:
        """(STEPS,) times [s] up to 0, and (STEPS, curves) values; NaN without data."""
        ago = np.linspace(-SECONDS, 0.0, STEPS)
        result = np.full((STEPS, len(self._curves)), np.nan)
        rows = self._rows[KEPT - self._count :]
        if len(rows):
            seen = np.flatnonzero(ago >= rows[0, 0] - rows[-1, 0] - 1e-9)
            at = np.searchsorted(rows[:, 0], rows[-1, 0] + ago[seen], side="right") - 1
            result[seen] = rows[np.maximum(at, 0), 1:]
        return ago, result


def drawable(ago: Values, values: Values) -> tuple[Values, ...]:
    """Columns of one plot for uPlot: times [s] and curves (STEPS,), without NaN, which uPlot cannot scale.

    Times before the first data are clamped to it. A curve holds its last value through a gap. A curve without data is
    drawn below the last one, which must be one that every source has.
    """
    known = [curve for curve in values.T if np.isfinite(curve).any()]
    if not known:
        return (ago, *np.zeros_like(values.T))
    begin = min(int(np.isfinite(curve).argmax()) for curve in known)
    curves = [_filled(curve if np.isfinite(curve).any() else known[-1]) for curve in values.T]
    return (np.maximum(ago, ago[begin]), *curves)


def _filled(curve: Values) -> Values:
    """(STEPS,) with gaps filled by the previous value, and the start by the first one."""
    finite = np.isfinite(curve)
    at = np.maximum.accumulate(np.where(finite, np.arange(len(curve)), -1))
    return curve[np.where(at < 0, finite.argmax(), at)]


class Plots:
    """The plots in a gui. `add` every frame; `draw` at a readable rate."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._history = History()
        ago, values = self._history.sampled()
        self._heads, self._charts = [], []
        first = 0
        for plot in PLOTS:
            last = first + len(plot.curves)
            self._heads.append(gui.add_html(""))
            self._charts.append(_chart(gui, plot, drawable(ago, values[:, first:last])))
            first = last

    def add(self, frame: Frame) -> None:
        """Adds a frame."""
        self._history.add(frame)

    def draw(self, frame: Frame) -> None:
        """Draws the curves; the numbers are the frame's."""
        ago, values = self._history.sampled()
        first = 0
        for plot, head, chart in zip(PLOTS, self._heads, self._charts, strict=True):
            last = first + len(plot.curves)
            chart.data = drawable(ago, values[:, first:last])
            head.content = head_of(plot, frame)
            first = last


def head_of(plot: Plot, frame: Frame) -> str:
    """HTML: the title, and each curve's name in its color with its current value."""
    keys = []
    for curve in plot.curves:
        name, value = curve.name(frame.driver), curve.value(frame)
        if name:
            # Adding zero avoids "-0.0".
            number = f"{round(value, plot.digits) + 0.0:.{plot.digits}f}" if math.isfinite(value) else "–"
            keys.append(
                f'<span style="white-space:nowrap;margin-right:.6em"><span style="color:{curve.color}">━</span> '
                f'{html.escape(name)} <b style="font-variant-numeric:tabular-nums">{number}</b></span>'
            )
    return (
        '<div style="font-size:.75em;line-height:1.35;padding:0 .75em;margin-bottom:-.4em">'
        f"<b>{plot.title}</b> [{plot.unit}] &ensp;{' '.join(keys)}</div>"
    )


def _chart(gui: viser.GuiApi, plot: Plot, data: tuple[Values, ...]) -> viser.GuiUplotHandle:
    curves = [
        uplot.Series(label=str(i), stroke=curve.color, width=curve.width, points={"show": False})
        for i, curve in enumerate(plot.curves)
    ]
    scales: dict[str, uplot.Scale] = {"x": uplot.Scale(time=False, range=(-SECONDS, 0.0))}
    if plot.lowest is not None:
        low = {"hard": plot.lowest, "soft": plot.lowest, "mode": 1}
        scales["y"] = uplot.Scale(range={"min": low, "max": {"pad": 0.1}})
    last = plot is PLOTS[-1]
    return gui.add_uplot(
        data,
        (uplot.Series(label="s"), *curves),
        scales=scales,
        axes=(uplot.Axis(show=last, size=22, font=FONT, gap=2), uplot.Axis(font=FONT, gap=2, size=42)),
        legend={"show": False},
        cursor={"show": False},
        height=HEIGHT + 22 * last,
        padding=(6, 8, 4, 0),
    )
