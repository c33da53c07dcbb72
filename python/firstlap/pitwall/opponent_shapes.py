"""Scene objects for the other drivers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from firstlap.perception.scan import laser_of
from firstlap.pitwall.frame import Points
from firstlap.pitwall.layers import AIM, KNOWN, LINE, PATH, RETURNS
from firstlap.pitwall.local_shapes import RING, STROKE
from firstlap.pitwall.opponents import ABOVE, NO_LINES, draw
from firstlap.pitwall.primitives import Cloud, Fan, LineSegments, Sheet, Solid, SpeedLine
from firstlap.pitwall.shapes import chain, circle, ring
from firstlap.plots.colors import BAD, FREE, INK, LEFT, RETURN, RIGHT, rgb
from firstlap.plots.colors import LINE as LINE_COLOR
from firstlap.plots.colors import PATH as PATH_COLOR


class OpponentShapes:
    """geometry: section `geometry` of the car file, SI units."""

    def __init__(self, sheet: Sheet, geometry: Mapping[str, float]) -> None:
        self._geometry = geometry
        self._laser = np.array(laser_of(geometry))
        self._returns = Cloud(sheet, f"{RETURNS.node}/all", rgb(RETURN), 0.04, 0.03)
        self._known = Cloud(sheet, f"{KNOWN.node}/walls", rgb(INK, 0.45), 0.035, 0.012)
        self._line = Cloud(sheet, f"{LINE.node}/racing", rgb(LINE_COLOR), 0.035, 0.015)
        self._free = Fan(sheet, f"{AIM.node}/free", rgb(FREE), 0.10, 0.002)
        self._chosen = Fan(sheet, f"{AIM.node}/chosen", rgb(FREE), 0.18, 0.004)
        self._trouble = Cloud(sheet, f"{AIM.node}/trouble", rgb(BAD), 0.11, 0.04)
        self._aim = LineSegments(sheet, f"{AIM.node}/ray", rgb(PATH_COLOR), 2.5)
        self._goal = Solid(sheet, f"{AIM.node}/goal", ring(RING, STROKE), rgb(PATH_COLOR), visible=False)
        self._arc = LineSegments(sheet, f"{AIM.node}/arc", rgb(INK), 2.0)
        self._wanted = LineSegments(sheet, f"{AIM.node}/wanted", rgb(BAD), 2.0)
        self._left = LineSegments(sheet, f"{AIM.node}/left", rgb(LEFT), 2.0)
        self._right = LineSegments(sheet, f"{AIM.node}/right", rgb(RIGHT), 2.0)
        self._spread = LineSegments(sheet, f"{AIM.node}/spread", rgb(PATH_COLOR), 2.0)
        self._outlines = LineSegments(sheet, f"{PATH.node}/outlines", rgb(PATH_COLOR, 0.4), 1.0)
        self._plan = SpeedLine(sheet, f"{PATH.node}/plan", 0.07, 0.035)

    def show(self, driver: str, trace: Mapping[str, Any], top: float) -> None:
        """Shows a step of a driver; nothing for driver local. top [m/s]: upper end of the speed color scale."""
        drawing = draw(driver, trace, self._geometry)
        self._returns.show(drawing.returns)
        self._known.show(drawing.known)
        self._line.show(drawing.line)
        self._free.show(self._laser, drawing.free)
        self._chosen.show(self._laser, drawing.chosen)
        self._trouble.show(drawing.trouble)
        self._aim.show(chain(drawing.aim, ABOVE))
        self._show_goal(drawing.aim)
        self._arc.show(chain(drawing.arc, ABOVE))
        self._wanted.show(chain(drawing.wanted, ABOVE))
        self._left.show(drawing.left)
        self._right.show(drawing.right)
        self._spread.show(circle(np.zeros(2), drawing.spread, 2.0 * ABOVE) if drawing.spread else NO_LINES)
        self._outlines.show(drawing.outlines)
        self._plan.show(drawing.plan, drawing.plan_speed, top)

    def _show_goal(self, aim: Points) -> None:
        if len(aim):
            self._goal.show(float(aim[-1][0]), float(aim[-1][1]), ABOVE, 0.0)
        else:
            self._goal.hide()
