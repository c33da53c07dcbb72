"""The picture of a step, whichever driver it is of."""

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

PICTURES: dict[str, Callable[[StepSnapshot], Figure]] = {
    "local": draw_local,
    "gap": draw_gap,
    "disparity": draw_disparity,
    "pid": draw_pid,
    "global": draw_global,
}
"""Driver -> what draws a step of it."""


def plot_step(snapshot: StepSnapshot, path: str | Path) -> None:
    """Writes the picture of `snapshot`, in its driver's way. Raises InputError, also for a driver without a picture."""
    draw = PICTURES.get(snapshot.driver)
    if draw is None:
        raise InputError(f"driver {snapshot.driver}: no picture of a step; drivers with one are {', '.join(PICTURES)}")
    save(draw(snapshot), path)
