"""The pit wall as a whole: the server, what everybody sees, what each viewer has, and the loop that shows frames."""

from __future__ import annotations

import json
import logging
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

import rich
import viser
from viser import _messages

from firstlap.colours import PATH, rgb
from firstlap.view.camera import ViewControls, Viewpoint, first_look
from firstlap.view.frame import Frame
from firstlap.view.lap_table import LapTable
from firstlap.view.plots import Plots
from firstlap.view.scene import Scene
from firstlap.view.source import Source
from firstlap.view.status import StatusLine

FASTEST = 30.0
"""Frames shown per second at most."""
PLOTTED = 8.0
"""Times per second that plots, table and status are written anew."""
COUNTED = 2.0
"""[s] over which frames shown per second are counted."""
LEFT_WIDTH, RIGHT_WIDTH = 380, 360
"""Pixels of the panels at the sides."""


class Shown(Protocol):
    """What a viewer's panel is to the app."""

    def update(self, frame: Frame) -> None:
        """Shows what of the frame belongs there. Called as often as plots are."""


MakePanel = Callable[[viser.ClientHandle, bool], Shown]
"""A viewer's panel, and whether he may control. It adds to `client.gui`, which stands in a tab of its own then."""


class Gate(Protocol):
    """Who may come in, and who may control."""

    def open(self, host: str, port: int) -> viser.ViserServer:
        """A server that nobody gets past the gate of."""

    def may_control(self, client: viser.ClientHandle) -> bool:
        """Whether that viewer may do more than watch."""


class OpenGate:
    """Everybody may do everything."""

    def open(self, host: str, port: int) -> viser.ViserServer:
        """A plain server."""
        return viser.ViserServer(host=host, port=port, verbose=False)

    def may_control(self, client: viser.ClientHandle) -> bool:
        """Yes."""
        return True


class _Viewer:
    """What one browser has of its own. A reload is another viewer."""

    def __init__(self, client: viser.ClientHandle, source: Source, panel: MakePanel | None, may_control: bool) -> None:
        self.viewpoint = Viewpoint(client, source.scenery)
        self.panel: Shown | None = None
        tabs = client.gui.add_tab_group()
        if panel:
            with tabs.add_tab("Control" if may_control else "Watch"):
                self.panel = panel(client, may_control)
        with tabs.add_tab("View"):
            ViewControls(client.gui, self.viewpoint)


class App:
    """A running pit wall. It neither starts nor closes the source."""

    def __init__(self, source: Source, server: viser.ViserServer, gate: Gate, panel: MakePanel | None) -> None:
        self._source = source
        self._server = server
        self._gate = gate
        self._make_panel = panel
        self._viewers: dict[int, _Viewer] = {}
        self._moments: deque[float] = deque(maxlen=int(COUNTED * FASTEST) + 8)
        self._done = threading.Event()
        self._last: Frame | None = None
        self._written = 0.0
        self._dress()
        self.scene = Scene(server, source.scenery, source.car)
        self._status = StatusLine(server.gui)
        side = server.gui.add_panel()
        with side.add_tab("Laps and plots"):
            self._table = LapTable(server.gui)
            self._plots = Plots(server.gui)
        side.dock_left()
        side.set_width(LEFT_WIDTH)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(RIGHT_WIDTH)
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
        return len(self._viewers)

    def viewpoint(self, client_id: int) -> Viewpoint | None:
        """Of that viewer; None before he is there and after he left. Says where on the map he clicked."""
        viewer = self._viewers.get(client_id)
        return viewer.viewpoint if viewer else None

    def close(self) -> None:
        """Ends the loop and the server; browsers say that they are disconnected. Twice is once."""
        if self._done.is_set():
            return
        self._done.set()
        self._loop.join()
        said = rich.get_console()
        before, said.quiet = said.quiet, True
        try:
            self._server.stop()
        finally:
            said.quiet = before

    def _dress(self) -> None:
        gui, title = self._server.gui, f"firstlap — {self._source.title}"
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=rgb(PATH))
        gui.set_panel_label(self._source.title)
        # viser has no call for the window's title.
        script = _messages.RunJavascriptMessage(source=f"document.title = {json.dumps(title)};")
        self._server._websock_server.queue_message(script)
        self._server.scene.world_axes.visible = False
        first_look(self._server)

    # Viewers come and go.

    def _enter(self, client: viser.ClientHandle) -> None:
        with suppress(RuntimeError):  # gone again meanwhile
            self._viewers[client.client_id] = _Viewer(
                client, self._source, self._make_panel, self._gate.may_control(client)
            )

    def _leave(self, client: viser.ClientHandle) -> None:
        self._viewers.pop(client.client_id, None)

    # Frames.

    def _run(self) -> None:
        due = time.monotonic()
        while not self._done.wait(max(0.0, due - time.monotonic())):
            due = max(due + 1.0 / FASTEST, time.monotonic())
            frame = self._source.latest()
            if frame is None:
                continue
            if self._last is None or frame.number != self._last.number:
                self._show(frame)
            if time.monotonic() - self._written >= 1.0 / PLOTTED:
                self._write(frame)

    def _show(self, frame: Frame) -> None:
        self._last = frame
        self.scene.show(frame)
        self._plots.add(frame)
        for viewer in tuple(self._viewers.values()):
            viewer.viewpoint.show(self.scene.pose)
        self._moments.append(time.monotonic())

    def _write(self, frame: Frame) -> None:
        self._written = time.monotonic()
        with self._server.atomic():
            self._status.show(frame, self._source.setup.title, self.updates, self.scene.top)
            self._table.show(frame)
            self._plots.draw(frame)
        for viewer in tuple(self._viewers.values()):
            if viewer.panel:
                viewer.panel.update(frame)


def serve(
    source: Source,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    gate: Gate | None = None,
    panel: MakePanel | None = None,
) -> App:
    """Shows a source that was started. The next free port is taken, `App.port`; 0 is any.

    panel: makes each viewer's controls; without it everybody only watches.
    """
    # What is sent to a browser that has just gone is lost, and that is all right.
    warnings.filterwarnings("ignore", message=r"Queued a \w+ on a closed connection")
    logging.getLogger("websockets").setLevel(logging.CRITICAL)
    gate = gate or OpenGate()
    return App(source, gate.open(host, port), gate, panel)
