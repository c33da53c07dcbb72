"""The car to scale: body, wheels at the measured steering angle, and an arrow for the commanded one."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from firstlap.perception.scan import laser_of
from firstlap.pitwall.layers import BODY
from firstlap.pitwall.primitives import LineSegments, Sheet, Solid
from firstlap.pitwall.shapes import Mesh, arrow, chain, disc, merged, moved, prism
from firstlap.plots.colors import INK, PAPER, PATH, rgb

FLOOR, ROOF = 0.06, 0.10
"""[m] Heights of the body's bottom and top; seen from above, they only determine occlusion."""
WHEEL = (0.11, 0.05)
"""Length and width [m]."""
ARROW = 0.75
"""[m] Length."""


class CarShape:
    """geometry: section `geometry` of the car file, SI units."""

    def __init__(self, sheet: Sheet, geometry: Mapping[str, float]) -> None:
        self._axle = geometry["wheelbase"]
        self._track = 0.5 * (geometry["width"] - WHEEL[1])
        node = BODY.node
        body, outline = _body(geometry)
        rear = merged([moved(_wheel(), 0.0, side * self._track) for side in (-1.0, 1.0)])
        x, y = laser_of(geometry)
        self._rigid = [
            Solid(sheet, f"{node}/chassis", body, rgb(PAPER)),
            Solid(sheet, f"{node}/rear", rear, rgb(INK)),
            Solid(sheet, f"{node}/laser", moved(disc(0.025, ROOF + 0.01), x, y), rgb(PATH)),
        ]
        self._edge = chain(outline, ROOF + 0.005)
        self._outline = LineSegments(sheet, f"{node}/outline", rgb(INK), 2.0)
        self._front = [
            (Solid(sheet, f"{node}/front_{name}", _wheel(), rgb(INK)), side * self._track)
            for name, side in (("left", 1.0), ("right", -1.0))
        ]
        self._arrow = Solid(sheet, f"{node}/command", arrow(ARROW, 0.02, 0.13), rgb(INK), visible=False)

    def show(self, steering_angle: float, commanded: float) -> None:
        """Shows measured and commanded steering angle [rad]; NaN hides it."""
        for part in self._rigid:
            part.show()
        self._outline.show(self._edge)
        angle = steering_angle if math.isfinite(steering_angle) else 0.0
        for wheel, side in self._front:
            wheel.show(self._axle, side, 0.0, angle)
        if math.isfinite(commanded):
            self._arrow.show(self._axle, 0.0, ROOF + 0.02, commanded)
        else:
            self._arrow.hide()


def _body(geometry: Mapping[str, float]) -> tuple[Mesh, np.ndarray]:
    """The body with cut front corners, and its closed outline."""
    rear, half = -geometry["rear_overhang"], 0.5 * geometry["width"]
    front, cut = rear + geometry["length"], 0.3 * half
    outline = np.array(
        [
            [rear, -half],
            [front - 2 * cut, -half],
            [front, cut - half],
            [front, half - cut],
            [front - 2 * cut, half],
            [rear, half],
        ]
    )
    return prism(outline, FLOOR, ROOF), np.vstack([outline, outline[:1]])


def _wheel() -> Mesh:
    x, y = 0.5 * WHEEL[0], 0.5 * WHEEL[1]
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), 0.0, ROOF + 0.015)
