"""A viewer's panel: all controls, or read-only."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Protocol

import viser

from firstlap.common.errors import InputError
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup
from firstlap.pitwall.camera import OnMap, ground_point
from firstlap.pitwall.conditions import OFTEN
from firstlap.pitwall.control_panel import ControlPanel
from firstlap.pitwall.drive_panel import DrivePanel, PlacementPanel, StatePanel
from firstlap.pitwall.frame import Frame
from firstlap.pitwall.limits_panel import LimitsPanel
from firstlap.pitwall.setup_panel import SetupPanel
from firstlap.pitwall.source import Drives, Plays, Simulates, Source
from firstlap.pitwall.transport import Transport
from firstlap.pitwall.viewer_session import ViewerSession
from firstlap.tuning.space import usual


class AnyPanel(Protocol):
    """A viewer's panel."""

    def update(self, frame: Frame) -> None:
        """Shows the newest frame, which may be unchanged. Never blocks."""

    def close(self) -> None:
        """The viewer has disconnected, or gets other controls."""


class Panel:
    """All controls, for a viewer with control. folder: where setups are saved."""

    def __init__(
        self, client: viser.ClientHandle, source: Source, folder: Path | None = None, on_map: OnMap = ground_point
    ) -> None:
        self._session = ViewerSession(client)
        self._source = source
        self._on_map = on_map
        self._seen: Setup | None = None
        self._closed = False
        self._updates: list[Callable[[Frame], None]] = []
        self._keys: list[DrivePanel | Transport] = []
        gui = client.gui
        with client.atomic():
            self._build_top()
            self._tabs = gui.add_tab_group()
            with self._tabs.add_tab("Tune"):
                self._limits = LimitsPanel(gui)
                self._parameters_folder = gui.add_folder(None)
            with self._tabs.add_tab("Setup"):
                self._changed_folder = gui.add_folder(None)
                self._setup = SetupPanel(self._session, source, folder if folder is not None else Path.cwd())
            self._loaded = source.loaded
            self._parameters = self._build_parameters()
            self._conditions = self._build_conditions()

    def update(self, frame: Frame) -> None:
        """See AnyPanel."""
        with self._session.lock:
            if self._closed:
                return
            try:
                for update in self._updates:
                    update(frame)
                self._follow()
            except InputError:
                # The driver was changed concurrently; the next update shows the new one.
                self._seen = None
            except Exception as error:
                self._session.report_failure("showing", error)

    def close(self) -> None:
        """See AnyPanel."""
        with self._session.lock:
            if not self._closed:
                self._closed = True
                for keys in self._keys:
                    keys.close()

    def _build_top(self) -> None:
        source = self._source
        if isinstance(source, Drives):
            drive = DrivePanel(self._session, source)
            self._keys.append(drive)
            self._updates.append(drive.update)
        if isinstance(source, Plays):
            transport = Transport(self._session, source)
            self._keys.append(transport)
            self._updates.append(transport.update)

    def _build_conditions(self) -> ControlPanel | None:
        source = self._source
        if not isinstance(source, Simulates):
            return None
        table = source.conditions
        with self._tabs.add_tab("Simulator"):
            place = PlacementPanel(self._session, source, source.scenery.centerline, self._on_map)
            self._updates.append(place.update)
            return ControlPanel(
                self._session,
                table,
                [field for field in table.fields if field.key in OFTEN],
                source.condition,
                lambda key: table.find(key, "conditions").default,
                source.set_condition,
                self._one_by_one(source.set_condition),
                many=False,
            )

    def _build_parameters(self) -> ControlPanel:
        source = self._source
        setup = source.setup
        table = setup.fields
        with self._parameters_folder:
            return ControlPanel(
                self._session,
                table,
                usual(setup.driver, table),
                lambda key: source.setup.get(key),
                lambda key: source.loaded.get(key),
                self._change_one,
                source.change,
                changed_in=self._changed_folder,
            )

    @staticmethod
    def _one_by_one(change: Callable[[str, Value], None]) -> Callable[[dict[str, Value]], None]:
        def together(values: dict[str, Value]) -> None:
            for key, value in values.items():
                change(key, value)

        return together

    def _change_one(self, key: str, value: Value) -> None:
        self._source.change({key: value})

    def _follow(self) -> None:
        """Shows changes by other viewers or programs."""
        setup, loaded = self._source.setup, self._source.loaded
        if loaded is not self._loaded:
            self._take(loaded)
        if setup is not self._seen and setup.driver == self._loaded.driver:
            self._limits.update(setup, self._source.car)
            if self._parameters.sync():
                self._seen = setup
        if self._conditions is not None:
            self._conditions.sync()

    def _take(self, loaded: Setup) -> None:
        another = loaded.driver != self._loaded.driver
        self._loaded = loaded
        self._seen = None
        self._setup.load()
        with self._session.client.atomic():
            if another:
                self._parameters.remove()
                self._parameters = self._build_parameters()
            else:
                self._parameters.load()


class WatchPanel:
    """The read-only panel."""

    def __init__(self, client: viser.ClientHandle, source: Source) -> None:
        self._source = source
        self._seen: Setup | None = None
        self._state = StatePanel(client.gui) if isinstance(source, Drives) else None
        self._about = client.gui.add_html("")
        self._limits = LimitsPanel(client.gui)

    def update(self, frame: Frame) -> None:
        """See AnyPanel."""
        if self._state is not None:
            self._state.update(frame)
        setup = self._source.setup
        if setup is not self._seen:
            self._seen = setup
            self._limits.update(setup, self._source.car)
            self._about.content = f'<div style="padding:0 0.8em 0.5em">watching: {escape(setup.title)}</div>'

    def close(self) -> None:
        """See AnyPanel."""
