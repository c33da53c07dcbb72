"""Controls of a driving car: stop, go, restart, place."""

from __future__ import annotations

import math
import time
from html import escape
from typing import Any, Literal

import numpy as np
import viser
from viser import Icon

from firstlap.pitwall.camera import OnMap
from firstlap.pitwall.frame import Frame, Points, Pose
from firstlap.pitwall.source import Drives, Simulates
from firstlap.pitwall.viewer_session import ViewerSession, assign
from firstlap.plots.colors import BAD, GOOD

GO_LOCKOUT = 0.5
"""[s] After a stop, "go" is ignored for this time: the stop key also presses the focused button."""
BIG = "<style>[id='{uuid}']{{height:3.6em!important;font-size:1.15em!important;font-weight:800}}</style>"
NARROW = "<style>@media (min-width:36.01em){{*:has(> [id='{uuid}']){{display:none}}}}</style>"
"""Hides a control on wide pages. On a phone, all panels are in one long column."""
WIDTH = 270
"""[pixels] Width of the floating panel."""
STATE = '<div class="firstlap-state" style="padding:0 0.8em 0.5em"><b style="color:{color}">{state}</b> {reason}</div>'
SPACE: Literal["space"] = "space"
ESCAPE: Literal["escape"] = "escape"


class DrivePanel:
    """Stop and go in a separate panel that tabs and scrolling cannot hide."""

    def __init__(self, session: ViewerSession, source: Drives) -> None:
        self._session = session
        self._source = source
        self._stopped = -math.inf
        gui = session.gui
        for button in self._stop_and_go():
            gui.add_html(NARROW.format(uuid=button._impl.uuid))
        self._panel = gui.add_panel()
        with self._panel.add_tab("Car", Icon.STEERING_WHEEL):
            self._stop_and_go()
            if isinstance(source, Simulates):
                restart = gui.add_button("Restart", color="gray", icon=Icon.ROTATE_CLOCKWISE)
                restart.on_click(session.click("restart", source.restart))
            self._state = StatePanel(gui)
        # In a corner between the docked panels; notices appear in another corner.
        self._panel.float(x=-12, y=-12, width=WIDTH)
        self._panel.expand()
        self._keys = [
            gui.add_command("Emergency stop", description="until someone presses Go", hotkey=key, icon=Icon.HAND_STOP)
            for key in (SPACE, ESCAPE)
        ]
        for key in self._keys:
            key.on_trigger(self._stop)

    def update(self, frame: Frame) -> None:
        """Shows the newest frame."""
        self._state.update(frame)

    def _stop_and_go(self) -> list[viser.GuiButtonHandle]:
        gui = self._session.gui
        stop = gui.add_button("EMERGENCY STOP", color="red", icon=Icon.HAND_STOP)
        stop.on_click(self._stop)
        gui.add_html(BIG.format(uuid=stop._impl.uuid))
        go = gui.add_button("Go", color="green", icon=Icon.PLAYER_PLAY)
        go.on_click(self._session.click("go", self._go))
        return [stop, go]

    # On the event loop: in the thread pool, a stop could wait behind other requests.
    async def _stop(self, _event: Any) -> None:
        self._stopped = time.monotonic()
        self._source.stop()

    def _go(self) -> None:
        if time.monotonic() - self._stopped > GO_LOCKOUT:
            self._source.go()

    def close(self) -> None:
        """Removes the panel and its keys."""
        self._panel.remove()
        for key in self._keys:
            key.remove()


class PlacementPanel:
    """Places the simulated car by a click. Built in the current gui container."""

    def __init__(self, session: ViewerSession, source: Simulates, centerline: Points, on_map: OnMap) -> None:
        self._session = session
        self._source = source
        self._centerline = centerline
        self._on_map = on_map
        self._armed = False
        self._last: Pose | None = None
        self._now: Pose | None = None
        gui = session.gui
        self._button = gui.add_button("Place the car", color="gray", icon=Icon.MAP_PIN)
        self._button.on_click(session.click("place", self._arm))
        self._heading = gui.add_slider(
            "heading deg", -180.0, 180.0, 1.0, 0.0, hint="heading of the placed car", visible=False
        )
        self._heading.on_update(session.choice("place", self._turn, lambda: None))

    def update(self, frame: Frame) -> None:
        """Shows the newest frame."""
        self._now = frame.pose

    def _arm(self) -> None:
        with self._session.lock:
            if self._armed:
                self._disarm()
                return
            self._armed = True
            self._button.label = "Click on the ground (or here to cancel)"
            self._button.color = "orange"
            self._session.client.scene.on_click()(self._clicked)

    def _disarm(self) -> None:
        self._armed = False
        self._session.client.scene.remove_click_callback(self._clicked)
        self._button.label = "Place the car"
        self._button.color = "gray"

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        self._session.attempt("place", lambda: self._put(event.ray_origin, event.ray_direction))

    def _put(self, origin: tuple[float, float, float], direction: tuple[float, float, float]) -> None:
        with self._session.lock:
            spot = self._on_map(origin, direction)
            if not self._armed or spot is None:
                return
            self._disarm()
            pose = (*spot, heading_along(self._centerline, spot, self._now[2] if self._now else 0.0))
            self._source.place(pose)
            self._last = pose
            assign(self._heading, "value", math.degrees(pose[2]))
            self._heading.visible = True

    def _turn(self, degrees: float) -> None:
        with self._session.lock:
            if self._last is not None:
                self._last = (self._last[0], self._last[1], math.radians(degrees))
                self._source.place(self._last)


class StatePanel:
    """Shows whether the car drives, and why not."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")

    def update(self, frame: Frame) -> None:
        """Shows the newest frame."""
        state, color = ("driving", GOOD) if frame.may_drive else ("STOPPED", BAD)
        reason = "" if frame.may_drive else escape(frame.message)
        assign(self._html, "content", STATE.format(state=state, color=color, reason=reason))


def heading_along(line: Points, spot: tuple[float, float], otherwise: float) -> float:
    """Heading [rad] of the nearest segment of a line (N, 2); `otherwise` for an empty line."""
    if len(line) < 2:
        return otherwise
    steps = np.diff(line, axis=0)
    middles = line[:-1] + 0.5 * steps
    near = steps[int(np.argmin(np.sum((middles - np.asarray(spot)) ** 2, axis=1)))]
    return float(math.atan2(near[1], near[0]))
