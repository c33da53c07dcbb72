"""Drawings of driver `local`: perception and plan, from its trace (cpp/firstlap/drivers/trace.hpp)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from firstlap.pitwall.frame import Points
from firstlap.pitwall.layers import AIM, CLEANED, LINE, PATH, REMEMBERED, RETURNS, WIDTHS
from firstlap.pitwall.primitives import Cloud, LineSegments, Sheet, Solid, SpeedLine
from firstlap.pitwall.shapes import (
    NOTHING,
    Mesh,
    arrow,
    chain,
    column_in,
    joined,
    merged,
    moved,
    number_in,
    points_in,
    ring,
)
from firstlap.plots.colors import DROPPED, INK, LEFT, PAIR, RIGHT, rgb
from firstlap.plots.colors import LINE as LINE_COLOR
from firstlap.plots.colors import PATH as PATH_COLOR

RING = 0.12
"""[m] Radius of the ring around the lookahead point."""
STROKE, MARK_HEIGHT = 0.025, 0.045
"""[m] Line width and height of the mark."""
KEPT = 0
BOTH = 3
"""Status of a section that is kept, and support of a centerline point between two walls (segmentation,
centerline.hpp)."""


class LocalShapes:
    """Draws a step of driver `local`."""

    def __init__(self, sheet: Sheet) -> None:
        self._left = Cloud(sheet, f"{RETURNS.node}/left", rgb(LEFT), 0.04, 0.03)
        self._right = Cloud(sheet, f"{RETURNS.node}/right", rgb(RIGHT), 0.04, 0.03)
        self._dropped = Cloud(sheet, f"{RETURNS.node}/dropped", rgb(DROPPED), 0.03, 0.02)
        self._left_before = Cloud(sheet, f"{REMEMBERED.node}/left", rgb(LEFT, 0.6), 0.045, 0.018)
        self._right_before = Cloud(sheet, f"{REMEMBERED.node}/right", rgb(RIGHT, 0.6), 0.045, 0.018)
        self._widths = LineSegments(sheet, f"{WIDTHS.node}/pairs", rgb(PAIR, 0.45), 1.0)
        self._line = LineSegments(sheet, f"{LINE.node}/line", rgb(LINE_COLOR), 1.5)
        self._supported = Cloud(sheet, f"{LINE.node}/points", rgb(LINE_COLOR), 0.04, 0.022)
        self._smoothed = LineSegments(sheet, f"{CLEANED.node}/smoothed", rgb(INK), 1.5)
        self._simplified = Cloud(sheet, f"{CLEANED.node}/simplified", rgb(INK), 0.09, 0.04)
        self._path = SpeedLine(sheet, f"{PATH.node}/path", 0.07, 0.035)
        self._lookahead = Solid(sheet, f"{AIM.node}/lookahead", _mark(), rgb(PATH_COLOR), visible=False)

    def show(self, trace: Mapping[str, Any], top: float) -> None:
        """top [m/s]: upper end of the speed color scale. An empty trace shows nothing."""
        self._show_returns(trace)
        self._show_line(trace)
        self._path.show(points_of_path(trace), column_in(trace, "path", "velocity"), top)
        self._show_lookahead(trace)

    def _show_lookahead(self, trace: Mapping[str, Any]) -> None:
        x, y, yaw = (number_in(trace, "lookahead", name) for name in ("x", "y", "yaw"))
        if len(column_in(trace, "path", "s")) and math.isfinite(x + y + yaw):
            self._lookahead.show(x, y, MARK_HEIGHT, yaw)
        else:
            self._lookahead.hide()

    def _show_returns(self, trace: Mapping[str, Any]) -> None:
        right, left, dropped = by_side(trace)
        self._right.show(right)
        self._left.show(left)
        self._dropped.show(dropped)
        for side, cloud in (("left", self._left_before), ("right", self._right_before)):
            points, age = points_in(trace, side, "points"), column_in(trace, side, "age")
            cloud.show(points[age > 0.0] if len(points) == len(age) else NOTHING)

    def _show_line(self, trace: Mapping[str, Any]) -> None:
        line = points_in(trace, "line", "points")
        right, left = points_in(trace, "line", "right"), points_in(trace, "line", "left")
        both = column_in(trace, "line", "support") == BOTH
        paired = len(both) == len(right) == len(left)
        self._widths.show(joined(right[both][::2], left[both][::2], 0.008) if paired else joined(NOTHING, NOTHING, 0.0))
        self._line.show(chain(line, 0.02))
        self._supported.show(line[both] if len(both) == len(line) else NOTHING)
        self._smoothed.show(chain(points_in(trace, "smoothed"), 0.025))
        self._simplified.show(points_in(trace, "simplified"))


def points_of_path(trace: Mapping[str, Any]) -> Points:
    """(N, 2) of the planned path."""
    x, y = column_in(trace, "path", "x"), column_in(trace, "path", "y")
    return np.column_stack([x, y]) if len(x) == len(y) else NOTHING


def by_side(trace: Mapping[str, Any]) -> tuple[Points, Points, Points]:
    """Returns of the right wall, of the left wall, and dropped ones; (N, 2) each [m]."""
    points = points_in(trace, "points")
    split = number_in(trace, "split")
    side = np.full(len(points), 2)
    columns = (column_in(trace, "sections", name).astype(int) for name in ("first", "last", "status"))
    for i, (first, last, status) in enumerate(zip(*columns, strict=False)):
        if status == KEPT:
            side[first : last + 1] = 0 if i < split else 1
    return points[side == 0], points[side == 1], points[side == 2]


def _mark() -> Mesh:
    """The lookahead mark: a ring, and an arrow along the path."""
    return merged([ring(RING, STROKE), moved(arrow(4.0 * RING, STROKE, RING), RING, 0.0)])
