"""The pit wall as a whole: the server, what everybody sees, what each viewer has, and the loop that shows frames."""

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

from firstlap.pitwall.authentication import Authenticator, quietly
from firstlap.pitwall.camera import OnMap, ViewControls, Viewpoint, first_look
from firstlap.pitwall.frame import Frame
from firstlap.pitwall.lap_table import LapTable
from firstlap.pitwall.plots import Plots
from firstlap.pitwall.scene import Scene
from firstlap.pitwall.source import Source
from firstlap.pitwall.status import StatusLine
from firstlap.plots.colors import PATH, rgb

FASTEST = 30.0
"""Frames shown per second at most."""
PLOTTED = 8.0
"""Times per second that plots, table and status are written anew."""
PICTURE = 1.0 / 60.0
"""[s] between what viewers see and where they see it from: a browser shows new points one picture after a new pose."""
COUNTED = 2.0
"""[s] over which frames shown per second are counted."""
LEFT_WIDTH, RIGHT_WIDTH = 380, 360
"""Pixels of the panels at the sides."""


class Shown(Protocol):
    """What a viewer's panel is to the app."""

    def update(self, frame: Frame) -> None:
        """Shows what of the frame belongs there. Called as often as plots are drawn."""

    def close(self) -> None:
        """The viewer has gone."""


MakePanel = Callable[[viser.ClientHandle, bool, OnMap], Shown]
"""A viewer's panel; whether he may control; where on the map he clicks. It adds to the root of `client.gui`."""


class App:
    """A running pit wall. It neither starts nor closes the source."""

    def __init__(
        self, source: Source, server: viser.ViserServer, authenticator: Authenticator, panel: MakePanel | None
    ) -> None:
        self._source = source
        self._server = server
        self._authenticator = authenticator
        self._make_panel = panel
        self._entering = threading.Lock()
        self._viewpoints: dict[int, Viewpoint] = {}
        self._panels: dict[int, Shown] = {}
        self._moments: deque[float] = deque(maxlen=int(COUNTED * FASTEST) + 8)
        self._done = threading.Event()
        self._last: Frame | None = None
        self._written = 0.0
        self._trouble = ""
        self._dress()
        self._scenery = source.scenery
        self.scene = Scene(server, self._scenery, source.car)
        self._build()
        server.on_client_disconnect(self._leave)
        server.on_client_connect(self._enter)
        self._loop = threading.Thread(target=self._run, name="pit wall", daemon=True)
        self._loop.start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._server.get_port()

    @property
    def updates(self) -> float:
        """Frames shown per second, lately."""
        now = time.monotonic()
        return sum(1 for moment in tuple(self._moments) if now - moment <= COUNTED) / COUNTED

    @property
    def viewers(self) -> int:
        """How many browsers watch."""
        return len(self._viewpoints)

    def close(self) -> None:
        """Ends the loop and the server; browsers say that they are disconnected. Twice is once."""
        if self._done.is_set():
            return
        self._done.set()
        self._loop.join()
        for panel in tuple(self._panels.values()):
            panel.close()
        with quietly():
            self._server.stop()

    # What there is.

    def _dress(self) -> None:
        gui, title = self._server.gui, f"firstlap — {self._source.title}"
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=rgb(PATH))
        gui.set_panel_label(self._source.title)
        # viser has no call for the window's title.
        script = _messages.RunJavascriptMessage(source=f"document.title = {json.dumps(title)};")
        self._server._websock_server.queue_message(script)
        self._server.scene.world_axes.visible = False
        first_look(self._server)

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

    # Viewers come and go; a reload is another viewer.

    def _enter(self, client: viser.ClientHandle) -> None:
        with self._entering:
            viewpoint = Viewpoint(client, self._scenery)
            viewpoint.show(self.scene.pose)
            with self._view_tab:
                ViewControls(client.gui, viewpoint)
            panel = self._panel_of(client, viewpoint)
            self._viewpoints[client.client_id] = viewpoint
            if panel:
                self._panels[client.client_id] = panel
        if client.client_id not in self._server.get_clients():
            self._leave(client)

    def _panel_of(self, client: viser.ClientHandle, viewpoint: Viewpoint) -> Shown | None:
        if self._make_panel is None:
            return None
        return self._make_panel(client, self._authenticator.may_control(client), viewpoint.on_map)

    def _leave(self, client: viser.ClientHandle) -> None:
        self._viewpoints.pop(client.client_id, None)
        panel = self._panels.pop(client.client_id, None)
        if panel:
            panel.close()

    # Frames.

    def _run(self) -> None:
        due = time.monotonic()
        while not self._done.wait(max(0.0, due - time.monotonic())):
            due = max(due + 1.0 / FASTEST, time.monotonic())
            try:
                self._look()
            except Exception as error:
                self._say(f"{type(error).__name__}: {error}")

    def _look(self) -> None:
        frame = self._source.latest()
        self._surround()
        if frame is None:
            return
        if self._last is None or frame.number != self._last.number:
            self._last = frame
            self.scene.show(frame)
            self._plots.add(frame)
            self._done.wait(PICTURE)
            for viewpoint in tuple(self._viewpoints.values()):
                viewpoint.show(self.scene.pose)
            self._moments.append(time.monotonic())
        if time.monotonic() - self._written >= 1.0 / PLOTTED:
            self._written = time.monotonic()
            self._write(frame)

    def _surround(self) -> None:
        """A map that came late, or another one: walls, ground and overviews anew."""
        scenery = self._source.scenery
        if scenery is self._scenery:
            return
        with self._entering:
            self._scenery = scenery
            self.scene.surround(scenery)
            for viewpoint in tuple(self._viewpoints.values()):
                viewpoint.surround(scenery)

    def _write(self, frame: Frame) -> None:
        with self._server.atomic():
            self._status.show(frame, self._source.setup.title, self.updates, self.scene.top)
            self._table.show(frame)
            self._plots.draw(frame)
        for panel in tuple(self._panels.values()):
            panel.update(frame)

    def _say(self, trouble: str) -> None:
        """A frame that cannot be shown is said once, and the next one is shown."""
        if trouble != self._trouble:
            self._trouble = trouble
            print(f"view: {' '.join(trouble.split())[:200]}", file=sys.stderr)


def serve(
    source: Source,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    authenticator: Authenticator | None = None,
    panel: MakePanel | None = None,
) -> App:
    """Shows a source that was started; `App.port` says where. Raises InputError, as `Authenticator.open` does.

    panel: makes each viewer's controls; without it everybody only watches.
    """
    # What is sent to a browser that has just gone is lost, and that is all right.
    warnings.filterwarnings("ignore", message=r"Queued a \w+ on a closed connection")
    authenticator = authenticator or Authenticator()
    return App(source, authenticator.open(host, port), authenticator, panel)
