"""Plots a step of any driver."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from firstlap.common.errors import InputError
from firstlap.explain.disparity import draw_disparity
from firstlap.explain.gap import draw_gap
from firstlap.explain.global_map import draw_global
from firstlap.explain.local import draw_local
from firstlap.explain.pid import draw_pid
from firstlap.explain.snapshot import StepSnapshot
from firstlap.plots.primitives import save

STEP_PLOTS: dict[str, Callable[[StepSnapshot], Figure]] = {
    "local": draw_local,
    "gap": draw_gap,
    "disparity": draw_disparity,
    "pid": draw_pid,
    "global": draw_global,
}
"""Functions that draw a step, by driver."""


def plot_step(snapshot: StepSnapshot, path: str | Path) -> None:
    """Writes the plot of `snapshot`. Raises InputError, also for a driver without a plot."""
    draw = STEP_PLOTS.get(snapshot.driver)
    if draw is None:
        raise InputError(f"driver {snapshot.driver}: no plot of a step; expected one of {', '.join(STEP_PLOTS)}")
    save(draw(snapshot), path)
