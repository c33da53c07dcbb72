"""Each viewer's camera mode and hidden layers.

To follow the car, the viewer's camera is not moved. Instead, each viewer has its own root node of the map, which moves
under the camera. So zoom, pan and tilt are kept while following, and viewers do not affect each other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from threading import RLock

import numpy as np
import viser

from firstlap.pitwall.frame import Points, Pose, Scenery
from firstlap.pitwall.layers import LAYERS, MAP, Layer
from firstlap.pitwall.shapes import compose, inverse, rotation_about_z
from firstlap.pitwall.viewer_session import assign

FREE, FOLLOW, TURN = "Free", "Follow", "Follow and turn"
MODES = (FREE, FOLLOW, TURN)
FIELD_OF_VIEW = math.radians(40.0)
HEIGHT = 16.0
"""[m] Initial height of the camera."""
AHEAD = 1.4
"""[m] Look-ahead of the camera in mode TURN."""
TILT = 1e-3
"""[m] Offset from looking straight down; it defines the up direction on the screen."""
NO_TRACK = 10.0
"""[m] Half size of the overview without a track."""
HINT = "in all modes: drag to rotate, right button to pan, wheel to zoom"
Ray = tuple[float, float, float]
ORIGIN: Pose = (0.0, 0.0, 0.0)


def set_initial_camera(server: viser.ViserServer) -> None:
    """Sets the initial camera of new viewers, for mode `TURN`."""
    camera = server.initial_camera
    camera.fov = FIELD_OF_VIEW
    camera.position = (AHEAD - TILT, 0.0, HEIGHT)
    camera.look_at = (AHEAD, 0.0, 0.0)


OnMap = Callable[[Ray, Ray], "tuple[float, float] | None"]
"""Maps origin and direction of a `SceneClickEvent`'s ray to the ground point x, y [m] in the map frame."""


def ground_point(origin: Ray, direction: Ray) -> tuple[float, float] | None:
    """Intersection of a ray with z = 0, x and y [m]; None if there is none."""
    if not direction[2] or (along := -origin[2] / direction[2]) <= 0.0:
        return None
    x, y = origin[0] + along * direction[0], origin[1] + along * direction[1]
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


class Viewpoint:
    """The viewpoint of one viewer. Thread-safe."""

    def __init__(self, client: viser.ClientHandle, scenery: Scenery) -> None:
        self._client = client
        self._bounds = scenery.bounds()
        self._lock = RLock()
        self.mode = TURN
        self._pose: Pose = ORIGIN
        self._map_at: Pose = ORIGIN
        with client.atomic():
            self._map = client.scene.add_frame(MAP, show_axes=False)
            self._layers = {
                layer.node: client.scene.add_frame(layer.node, show_axes=False, visible=layer.shown) for layer in LAYERS
            }

    def surround(self, scenery: Scenery) -> None:
        """Sets the scenery, for the overview."""
        with self._lock:
            self._bounds = scenery.bounds()

    def show(self, pose: Pose) -> None:
        """Updates the view with the car's pose in the map frame."""
        with self._lock, self._client.atomic():
            self._pose = pose
            self._map_at = self._map_wanted()
            self._map.position = (self._map_at[0], self._map_at[1], 0.0)
            self._map.wxyz = rotation_about_z(self._map_at[2])

    def choose(self, mode: str) -> None:
        """Sets one of `MODES`. Mode FREE keeps the current view; the others center the car."""
        with self._lock, self._client.atomic():
            before, self.mode = self._map_at, mode
            self.show(self._pose)
            if mode == FREE:
                self._move_camera(compose(self._map_at, inverse(before)))
            elif mode == FOLLOW:
                self._look_down(np.zeros(2), HEIGHT, np.array([0.0, 1.0]))
            else:
                self._look_down(np.array([AHEAD, 0.0]), HEIGHT, np.array([1.0, 0.0]))

    def overview(self) -> None:
        """Shows the whole track, with a fixed camera."""
        with self._lock, self._client.atomic():
            self.mode = FREE
            self.show(self._pose)
            around = np.array(self._pose[:2])
            low, high = self._bounds or (around - NO_TRACK, around + NO_TRACK)
            half, camera = 0.5 * (high - low) + 1.0, self._client.camera
            height = max(half[1], half[0] / aspect_of(camera)) / math.tan(0.5 * camera.fov)
            self._look_down(0.5 * (low + high), height, np.array([0.0, 1.0]))

    def hide(self, layer: Layer, hidden: bool) -> None:
        """Hides or shows a layer."""
        self._layers[layer.node].visible = not hidden

    def on_map(self, origin: Ray, direction: Ray) -> tuple[float, float] | None:
        """As `OnMap`; accounts for this viewer's moved map."""
        spot = ground_point(origin, direction)
        return None if spot is None else compose(inverse(self._map_at), (*spot, 0.0))[:2]

    def _map_wanted(self) -> Pose:
        if self.mode == FREE:
            return ORIGIN
        return inverse(self._pose if self.mode == TURN else (*self._pose[:2], 0.0))

    def _look_down(self, at: Points, height: float, up: Points) -> None:
        """Looks straight down, with `up` pointing up on the screen."""
        camera = self._client.camera
        camera.up_direction = (0.0, 0.0, 1.0)
        camera.position = (*(at - TILT * up), height)
        camera.look_at = (*at, 0.0)

    def _move_camera(self, by: Pose) -> None:
        camera = self._client.camera
        moved = [(*compose(by, (p[0], p[1], 0.0))[:2], p[2]) for p in (camera.position, camera.look_at)]
        camera.position, camera.look_at = moved


def aspect_of(camera: viser.CameraHandle) -> float:
    """Aspect ratio of the viewport; 1 for a hidden page."""
    if camera.image_width <= 0 or camera.image_height <= 0:
        return 1.0
    return camera.image_width / camera.image_height


class ViewControls:
    """A viewer's controls for the camera and the layers."""

    def __init__(self, gui: viser.GuiApi, viewpoint: Viewpoint) -> None:
        mode = gui.add_dropdown("Camera", MODES, initial_value=viewpoint.mode, hint=HINT)
        overview = gui.add_button("Whole track", icon=viser.Icon.MAP)

        @mode.on_update
        def _(_event: object) -> None:
            viewpoint.choose(mode.value)

        @overview.on_click
        def _(_event: object) -> None:
            assign(mode, "value", FREE)
            viewpoint.overview()

        self.toggles = LayerToggles(gui, viewpoint)


class LayerToggles:
    """A checkbox for each layer."""

    def __init__(self, gui: viser.GuiApi, viewpoint: Viewpoint) -> None:
        self.checkboxes: dict[str, viser.GuiCheckboxHandle] = {}
        with gui.add_folder("Show"):
            for layer in LAYERS:
                self.checkboxes[layer.node] = self._checkbox(gui, viewpoint, layer)

    @staticmethod
    def _checkbox(gui: viser.GuiApi, viewpoint: Viewpoint, layer: Layer) -> viser.GuiCheckboxHandle:
        checkbox = gui.add_checkbox(layer.title, layer.shown, hint=layer.doc)

        @checkbox.on_update
        def _(_event: object) -> None:
            viewpoint.hide(layer, not checkbox.value)

        return checkbox
