"""The scene: what a car perceived and planned, at its pose."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import viser

from firstlap.config.car_file import Car
from firstlap.pitwall.car_shape import CarShape
from firstlap.pitwall.frame import Frame, Points, Pose, Scenery
from firstlap.pitwall.layers import BEFORE, LAYERS, MAP
from firstlap.pitwall.local_shapes import LocalShapes, points_of_path
from firstlap.pitwall.map_shapes import Ground, LapLines, Walls
from firstlap.pitwall.opponent_shapes import OpponentShapes
from firstlap.pitwall.opponents import draw
from firstlap.pitwall.primitives import LineSegments, Sheet
from firstlap.pitwall.shapes import NOTHING, chain, column_in
from firstlap.plots.colors import FAINT, rgb

SLOWEST_TOP = 2.0
"""[m/s] Minimum upper end of the speed color scale."""


class Scene:
    """Draws frames for all viewers. `Viewpoint` handles what each viewer hides or follows."""

    def __init__(self, server: viser.ViserServer, scenery: Scenery, car: Car) -> None:
        api = server.scene
        geometry: Mapping[str, float] = car.core.values()["geometry"]
        self._server = server
        self._geometry = geometry
        self.top = SLOWEST_TOP
        """[m/s] Upper end of the speed color scale: an integer that grows with the planned speeds."""
        api.add_frame(MAP, show_axes=False)
        for layer in LAYERS:
            api.add_frame(layer.node, show_axes=False)
        _light(api)
        still = Sheet(api)
        self._ground = Ground(still)
        self._walls = Walls(still)
        self.surround(scenery)
        self._laps = LapLines(still)
        self._sheet = Sheet(api)
        self._body = CarShape(self._sheet, geometry)
        self._before = LineSegments(self._sheet, f"{BEFORE.node}/path", rgb(FAINT), 3.0)
        self._local = LocalShapes(self._sheet)
        self._others = OpponentShapes(self._sheet, geometry)

    @property
    def pose(self) -> Pose:
        """Pose of the car in the scene; the origin if unknown."""
        return self._sheet.pose

    def surround(self, scenery: Scenery) -> None:
        """Replaces the static surroundings."""
        with self._server.atomic():
            self._ground.surround(scenery)
            self._walls.surround(scenery)

    def show(self, frame: Frame) -> None:
        """Shows a frame."""
        with self._server.atomic():
            self._sheet.pose = frame.pose or (0.0, 0.0, 0.0)
            self.top = max(self.top, _top_of(frame))
            self._local.show(frame.trace if frame.driver == "local" else {}, self.top)
            self._others.show(frame.driver, frame.trace, self.top)
            self._body.show(frame.steering_angle, commanded(frame)[1])
            self._laps.show(frame.laps)
            self._ground.show(self.pose)
            self._before.show(chain(self._path_before(frame), 0.03))

    def _path_before(self, frame: Frame) -> Points:
        """(N, 2) path of the loaded setup."""
        if frame.before is None:
            return NOTHING
        if frame.driver == "local":
            return points_of_path(frame.before)
        return draw(frame.driver, frame.before, self._geometry).aim


def _light(api: viser.SceneApi) -> None:
    """Uniform ambient light: colors are unchanged, and no shadows are rendered."""
    api.configure_default_lights(enabled=False, cast_shadow=False)
    api.configure_environment_map(None)
    api.add_light_ambient("/light", color=(255, 255, 255), intensity=math.pi)


def commanded(frame: Frame) -> tuple[float, float, str]:
    """Speed [m/s] and steering angle [rad] of the command, and status; NaN and "" before the first step."""
    speed, angle, status = frame.trace.get("result") or (math.nan, math.nan, "")
    if frame.sent is not None:
        speed, angle = frame.sent
    return float(speed), float(angle), str(status)


def planned_speeds(frame: Frame) -> np.ndarray:
    """(N,) speeds [m/s] along the path or plan; empty if the driver has none."""
    along_path = column_in(frame.trace, "path", "velocity")
    return along_path if len(along_path) else column_in(frame.trace, "plan_speed")


def _top_of(frame: Frame) -> float:
    speeds = planned_speeds(frame)
    fastest = float(speeds.max()) if len(speeds) else 0.0
    return math.ceil(fastest) if math.isfinite(fastest) else 0.0
