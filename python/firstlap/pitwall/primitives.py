"""Drawing primitives of the scene: viser objects that are created once and then updated.

Every object keeps its name, so that a browser that connects late gets only the newest state of each. Arrays that change
together (a line and its colors) keep their lengths, because a slow browser may get them separately.

A browser renders a node's new pose one frame before its new points. So moving objects have no pose: all of them, also
the car, are points that a `Sheet` transforms to the map frame. Everything that is sent together is then shown together.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import viser

from firstlap.pitwall.frame import Points, Pose
from firstlap.pitwall.shapes import (
    Faces,
    Mesh,
    Segments,
    chain,
    fan_faces,
    padded,
    raised,
    resampled,
)
from firstlap.plots.colors import SPEED_MAP

Color = tuple[int, int, int]
HIDDEN_POINT = np.zeros((1, 3), np.float32)
STEP = 64
"""Point clouds grow and shrink in multiples of this."""


def placed(pose: Pose, points: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """(..., 3) points in a frame at `pose`, transformed to the pose's parent frame."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return (points @ turn + (pose[0], pose[1], 0.0)).astype(np.float32)


class Sheet:
    """Transforms drawings in base_link to `pose` in the map frame; initially the origin."""

    def __init__(self, api: viser.SceneApi) -> None:
        self.api = api
        self.pose: Pose = (0.0, 0.0, 0.0)

    def placed(self, points: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """(..., 3) from base_link to the map frame."""
        return placed(self.pose, points)


class Cloud:
    """A point cloud of one color; size [m]."""

    def __init__(self, sheet: Sheet, name: str, color: Color, size: float, height: float) -> None:
        self._sheet, self._height = sheet, height
        self._handle = sheet.api.add_point_cloud(
            name,
            HIDDEN_POINT,
            color,
            point_size=size,
            point_shape="circle",
            precision="float32",
            point_shading="flat",
            visible=False,
        )

    def show(self, points: Points) -> None:
        """Replaces the content."""
        if len(points):
            self._handle.points = padded(self._sheet.placed(raised(points, self._height)), STEP)
        self._handle.visible = len(points) > 0


class LineSegments:
    """Line segments of one color; width [pixels]."""

    def __init__(self, sheet: Sheet, name: str, color: Color, width: float) -> None:
        self._sheet = sheet
        self._handle = sheet.api.add_line_segments(
            name, np.zeros((1, 2, 3)), color, thickness=width, thickness_units="screen", visible=False
        )

    def show(self, segments: Segments) -> None:
        """Replaces the content."""
        if len(segments):
            self._handle.points = self._sheet.placed(segments)
        self._handle.visible = len(segments) > 0

    def move(self, x: float, y: float) -> None:
        """Moves the drawing by x, y [m]."""
        self._handle.position = (x, y, 0.0)


class SpeedLine:
    """A polyline colored by speed; width [m]."""

    PIECES = 96

    def __init__(self, sheet: Sheet, name: str, width: float, height: float) -> None:
        self._sheet, self._height = sheet, height
        self._handle = sheet.api.add_line_segments(
            name,
            np.zeros((self.PIECES, 2, 3)),
            np.zeros((self.PIECES, 2, 3), np.uint8),
            thickness=width,
            thickness_units="world",
            visible=False,
        )

    def show(self, points: Points, speed: npt.NDArray[np.float64], top: float) -> None:
        """points (N, 2) [m], speed (N,) [m/s]; top: upper end of the color scale [m/s]."""
        seen = len(points) >= 2 and len(points) == len(speed)
        if seen:
            self._handle.points = self._sheet.placed(chain(resampled(points, self.PIECES + 1), self._height))
            colors = _linear(speed_colors(resampled(speed, self.PIECES + 1), top))
            self._handle.colors = np.stack([colors[:-1], colors[1:]], axis=1)
        self._handle.visible = seen


class Solid:
    """A rigid mesh."""

    def __init__(self, sheet: Sheet, name: str, mesh: Mesh, color: Color, visible: bool = True) -> None:
        self._sheet, self._vertices = sheet, mesh[0]
        self._handle = _mesh(sheet.api, name, mesh[0], mesh[1], color, None, visible)

    def show(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> None:
        """Shows the mesh at x, y, z [m], rotated by `yaw` [rad]."""
        there = placed((x, y, yaw), self._vertices) + np.array([0.0, 0.0, z], np.float32)
        self._handle.vertices = self._sheet.placed(there)
        self._handle.visible = True

    def hide(self) -> None:
        """Hides the mesh."""
        self._handle.visible = False

    def remove(self) -> None:
        """Removes the mesh."""
        self._handle.remove()


class Fan:
    """A translucent area between a point and a rim around it."""

    RIM = 181

    def __init__(self, sheet: Sheet, name: str, color: Color, opacity: float, height: float) -> None:
        self._sheet, self._height = sheet, height
        vertices = np.zeros((self.RIM + 1, 3), np.float32)
        self._handle = _mesh(sheet.api, name, vertices, fan_faces(self.RIM), color, opacity, visible=False)

    def show(self, middle: Points, rim: Points) -> None:
        """middle (2,), rim (N, 2), right to left."""
        if len(rim) >= 2:
            points = np.vstack([middle, resampled(rim, self.RIM)])
            self._handle.vertices = self._sheet.placed(raised(points, self._height))
        self._handle.visible = len(rim) >= 2


def speed_colors(speed: npt.NDArray[np.float64], top: float) -> npt.NDArray[np.uint8]:
    """(N, 3) RGB colors of speeds (N,), from 0 to `top` [m/s]."""
    table = _speed_table()
    share = np.clip(np.nan_to_num(speed) / max(top, 1e-6), 0.0, 1.0)
    return table[np.rint((len(table) - 1) * share).astype(int)]


@lru_cache
def _speed_table() -> npt.NDArray[np.uint8]:
    from matplotlib import colormaps

    return np.asarray(colormaps[SPEED_MAP](np.linspace(0.0, 1.0, 256), bytes=True)[:, :3])


def _linear(colors: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Converts sRGB to linear RGB: viser expects linear colors for line vertices, but sRGB elsewhere."""
    return np.rint(255.0 * (colors / 255.0) ** 2.2).astype(np.uint8)


def _mesh(
    api: viser.SceneApi,
    name: str,
    vertices: npt.NDArray[np.float32],
    faces: Faces,
    color: Color,
    opacity: float | None,
    visible: bool,
) -> viser.MeshHandle:
    return api.add_mesh_simple(
        name,
        vertices,
        faces,
        color=color,
        opacity=opacity,
        side="double",
        flat_shading=True,
        cast_shadow=False,
        receive_shadow=False,
        visible=visible,
    )
