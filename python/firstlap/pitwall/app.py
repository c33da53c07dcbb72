"""The pit wall application: the server, shared and per-viewer content, and the loop that shows frames."""

from __future__ import annotations

import json
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable
from typing import Protocol

import viser
from viser import _messages

from firstlap.pitwall.authentication import Authenticator, silenced
from firstlap.pitwall.camera import OnMap, ViewControls, Viewpoint, set_initial_camera
from firstlap.pitwall.frame import Frame
from firstlap.pitwall.lap_table import LapTable
from firstlap.pitwall.plots import Plots
from firstlap.pitwall.scene import Scene
from firstlap.pitwall.source import Source
from firstlap.pitwall.status import StatusLine
from firstlap.plots.colors import PATH, rgb

MAX_FRAME_RATE = 30.0
"""Maximum frames per second."""
PLOT_RATE = 8.0
"""[Hz] Update rate of the plots, the table and the status."""
RENDER_DELAY = 1.0 / 60.0
"""[s] Delay between updating the points and the viewpoint: a browser renders new points one frame after a new pose."""
RATE_WINDOW = 2.0
"""[s] Window in which frames per second are counted."""
LEFT_WIDTH, RIGHT_WIDTH = 380, 360
"""[pixels] Width of the side panels."""


class ViewerPanel(Protocol):
    """The interface of a viewer's panel."""

    def update(self, frame: Frame) -> None:
        """Shows the frame. Called at the update rate of the plots."""

    def close(self) -> None:
        """The viewer has disconnected."""


MakePanel = Callable[[viser.ClientHandle, bool, OnMap], ViewerPanel]
"""Makes a viewer's panel in the root of `client.gui`, from the client, whether it may control, and the map picker."""


class App:
    """A running pit wall. It does not start or close the source."""

    def __init__(
        self, source: Source, server: viser.ViserServer, authenticator: Authenticator, panel: MakePanel | None
    ) -> None:
        self._source = source
        self._server = server
        self._authenticator = authenticator
        self._make_panel = panel
        self._connecting = threading.Lock()
        self._viewpoints: dict[int, Viewpoint] = {}
        self._panels: dict[int, ViewerPanel] = {}
        self._frame_times: deque[float] = deque(maxlen=int(RATE_WINDOW * MAX_FRAME_RATE) + 8)
        self._done = threading.Event()
        self._last: Frame | None = None
        self._updated = 0.0
        self._last_problem = ""
        self._configure_page()
        self._scenery = source.scenery
        self.scene = Scene(server, self._scenery, source.car)
        self._build()
        server.on_client_disconnect(self._on_disconnect)
        server.on_client_connect(self._on_connect)
        self._loop = threading.Thread(target=self._run, name="pit wall", daemon=True)
        self._loop.start()

    @property
    def port(self) -> int:
        """The port on which it listens."""
        return self._server.get_port()

    @property
    def updates(self) -> float:
        """Current frames per second."""
        now = time.monotonic()
        return sum(1 for shown_at in tuple(self._frame_times) if now - shown_at <= RATE_WINDOW) / RATE_WINDOW

    @property
    def viewers(self) -> int:
        """Number of connected browsers."""
        return len(self._viewpoints)

    def close(self) -> None:
        """Ends the loop and the server; browsers show that they are disconnected. Idempotent."""
        if self._done.is_set():
            return
        self._done.set()
        self._loop.join()
        for panel in tuple(self._panels.values()):
            panel.close()
        with silenced():
            self._server.stop()

    # The page.

    def _configure_page(self) -> None:
        gui, title = self._server.gui, f"firstlap — {self._source.title}"
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=rgb(PATH))
        gui.set_panel_label(self._source.title)
        # viser has no API for the window title.
        script = _messages.RunJavascriptMessage(source=f"document.title = {json.dumps(title)};")
        self._server._websock_server.queue_message(script)
        self._server.scene.world_axes.visible = False
        set_initial_camera(self._server)

    def _build(self) -> None:
        gui = self._server.gui
        self._status = StatusLine(gui)
        side = gui.add_panel()
        with side.add_tab("Laps and plots", viser.Icon.CHART_LINE):
            self._table = LapTable(gui)
            self._plots = Plots(gui)
        self._view_tab = side.add_tab("View", viser.Icon.EYE)
        side.dock_left()
        side.set_width(LEFT_WIDTH)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_WIDTH)

    # Viewers connect and disconnect; a reload is a new viewer.

    def _on_connect(self, client: viser.ClientHandle) -> None:
        with self._connecting:
            viewpoint = Viewpoint(client, self._scenery)
            viewpoint.show(self.scene.pose)
            with self._view_tab:
                ViewControls(client.gui, viewpoint)
            panel = self._panel_of(client, viewpoint)
            self._viewpoints[client.client_id] = viewpoint
            if panel:
                self._panels[client.client_id] = panel
        if client.client_id not in self._server.get_clients():
            self._on_disconnect(client)

    def _panel_of(self, client: viser.ClientHandle, viewpoint: Viewpoint) -> ViewerPanel | None:
        if self._make_panel is None:
            return None
        return self._make_panel(client, self._authenticator.may_control(client), viewpoint.on_map)

    def _on_disconnect(self, client: viser.ClientHandle) -> None:
        self._viewpoints.pop(client.client_id, None)
        panel = self._panels.pop(client.client_id, None)
        if panel:
            panel.close()

    # Frames.

    def _run(self) -> None:
        due = time.monotonic()
        while not self._done.wait(max(0.0, due - time.monotonic())):
            due = max(due + 1.0 / MAX_FRAME_RATE, time.monotonic())
            try:
                self._show_latest()
            except Exception as error:
                self._report(f"{type(error).__name__}: {error}")

    def _show_latest(self) -> None:
        frame = self._source.latest()
        self._update_scenery()
        if frame is None:
            return
        if self._last is None or frame.number != self._last.number:
            self._last = frame
            self.scene.show(frame)
            self._plots.add(frame)
            self._done.wait(RENDER_DELAY)
            for viewpoint in tuple(self._viewpoints.values()):
                viewpoint.show(self.scene.pose)
            self._frame_times.append(time.monotonic())
        if time.monotonic() - self._updated >= 1.0 / PLOT_RATE:
            self._updated = time.monotonic()
            self._update_panels(frame)

    def _update_scenery(self) -> None:
        """Redraws walls, ground and overviews if the source has a new map."""
        scenery = self._source.scenery
        if scenery is self._scenery:
            return
        with self._connecting:
            self._scenery = scenery
            self.scene.surround(scenery)
            for viewpoint in tuple(self._viewpoints.values()):
                viewpoint.surround(scenery)

    def _update_panels(self, frame: Frame) -> None:
        with self._server.atomic():
            self._status.show(frame, self._source.setup.title, self.updates, self.scene.top)
            self._table.show(frame)
            self._plots.draw(frame)
        for panel in tuple(self._panels.values()):
            panel.update(frame)

    def _report(self, problem: str) -> None:
        """Prints why a frame cannot be shown, once per cause; the loop continues."""
        if problem != self._last_problem:
            self._last_problem = problem
            print(f"view: {' '.join(problem.split())[:200]}", file=sys.stderr)


def serve(
    source: Source,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    authenticator: Authenticator | None = None,
    panel: MakePanel | None = None,
) -> App:
    """Shows a source that has been started, on `App.port`. Raises InputError as `Authenticator.open` does.

    panel: makes each viewer's controls; without it, the page is read-only.
    """
    # Messages to a browser that has just disconnected are lost; that is harmless.
    warnings.filterwarnings("ignore", message=r"Queued a \w+ on a closed connection")
    authenticator = authenticator or Authenticator()
    return App(source, authenticator.open(host, port), authenticator, panel)
