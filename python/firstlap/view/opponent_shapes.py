"""The drawings of the other drivers, in the scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from firstlap.colours import BAD, FREE, INK, LEFT, RETURN, RIGHT, rgb
from firstlap.colours import LINE as LINE_COLOUR
from firstlap.colours import PATH as PATH_COLOUR
from firstlap.view.layers import AIM, KNOWN, LINE, PATH, RETURNS
from firstlap.view.opponents import ABOVE, draw
from firstlap.view.pens import Cloud, Fan, Solid, SpeedLine, Strokes
from firstlap.view.shapes import about_z, chain, ring


class OpponentShapes:
    """geometry: of the car file's section of that name, SI."""

    def __init__(self, api: viser.SceneApi, geometry: Mapping[str, float]) -> None:
        self._geometry = geometry
        self._laser = np.array([geometry["laser_x"], 0.0])
        self._returns = Cloud(api, f"{RETURNS.node}/all", rgb(RETURN), 0.055, 0.03)
        self._known = Cloud(api, f"{KNOWN.node}/walls", rgb(INK), 0.05, 0.012)
        self._line = Cloud(api, f"{LINE.node}/racing", rgb(LINE_COLOUR), 0.05, 0.015)
        self._free = Fan(api, f"{AIM.node}/free", rgb(FREE), 0.10, 0.002)
        self._chosen = Fan(api, f"{AIM.node}/chosen", rgb(FREE), 0.18, 0.004)
        self._trouble = Cloud(api, f"{AIM.node}/trouble", rgb(BAD), 0.11, 0.04)
        self._aim = Strokes(api, f"{AIM.node}/ray", rgb(PATH_COLOUR), 2.5)
        self._goal = Solid(api, f"{AIM.node}/goal", ring(0.10, 0.135), rgb(PATH_COLOUR), visible=False)
        self._arc = Strokes(api, f"{AIM.node}/arc", rgb(INK), 2.0)
        self._wanted = Strokes(api, f"{AIM.node}/wanted", rgb(BAD), 2.0)
        self._left = Strokes(api, f"{AIM.node}/left", rgb(LEFT), 2.0)
        self._right = Strokes(api, f"{AIM.node}/right", rgb(RIGHT), 2.0)
        self._spread = Strokes(api, f"{AIM.node}/spread", rgb(PATH_COLOUR), 2.0)
        self._outlines = Strokes(api, f"{PATH.node}/outlines", rgb(PATH_COLOUR, 0.4), 1.0)
        self._plan = SpeedLine(api, f"{PATH.node}/plan", 0.07, 0.035)

    def show(self, driver: str, trace: Mapping[str, Any], top: float) -> None:
        """A step of that driver; of driver local nothing. top [m/s]: where the colours of speeds end."""
        drawing = draw(driver, trace, self._geometry)
        self._returns.show(drawing.returns)
        self._known.show(drawing.known)
        self._line.show(drawing.line)
        self._free.show(self._laser, drawing.free)
        self._chosen.show(self._laser, drawing.chosen)
        self._trouble.show(drawing.trouble)
        self._aim.show(chain(drawing.aim, ABOVE))
        if len(drawing.aim):
            self._goal.show(float(drawing.aim[-1, 0]), float(drawing.aim[-1, 1]), ABOVE, about_z(0.0))
        else:
            self._goal.hide()
        self._arc.show(chain(drawing.arc, ABOVE))
        self._wanted.show(chain(drawing.wanted, ABOVE))
        self._left.show(drawing.left)
        self._right.show(drawing.right)
        self._spread.show(chain(_circle(drawing.spread), ABOVE))
        self._outlines.show(drawing.outlines)
        self._plan.show(drawing.plan, drawing.plan_speed, top)


def _circle(radius: float) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, 33 if radius > 0.0 else 0)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])
