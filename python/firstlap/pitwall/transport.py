"""Playback controls of a recording: play, pause, step, seek, speed."""

from __future__ import annotations

import time
from typing import Any

import viser
from viser import Icon

from firstlap.pitwall.controls import HOLD
from firstlap.pitwall.frame import Frame
from firstlap.pitwall.source import Plays
from firstlap.pitwall.viewer_session import ViewerSession, assign

PACES = ("0.1", "0.25", "0.5", "1", "2", "5", "10")


class Transport:
    """Built in the current gui container."""

    def __init__(self, session: ViewerSession, source: Plays) -> None:
        self._session = session
        self._source = source
        self._touched = float("-inf")
        gui = session.gui
        with gui.add_folder("Recording"):
            self._play = gui.add_button("Play", icon=Icon.PLAYER_PLAY)
            self._play.on_click(session.click("play", self._toggle))
            self._steps = gui.add_button_group("step", ("-100", "-10", "-1", "+1", "+10", "+100"))
            self._steps.on_click(session.click("step", lambda: self._step(int(self._steps.value))))
            last = max(source.scans - 1, 1)
            self._scan = gui.add_slider("scan", 0, last, 1, 0, hint=f"of {source.scans}; type or drag")
            self._scan.on_update(session.choice("seek", self._seek, lambda: None))
            pace = f"{source.pace:g}"
            paces = PACES if pace in PACES else (pace, *PACES)
            self._pace = gui.add_dropdown("playback speed", paces, initial_value=pace, hint="multiple of real time")
            self._pace.on_update(session.choice("pace", lambda value: source.set_pace(float(value)), lambda: None))
            self._where = gui.add_html("")
        self._keys = self._bind()

    def _bind(self) -> list[viser.CommandHandle]:
        gui = self._session.gui
        keys = [
            (gui.add_command("Play or pause", hotkey="space"), self._toggle),
            (gui.add_command("Step forward", hotkey="arrowright"), lambda: self._step(1)),
            (gui.add_command("Step back", hotkey="arrowleft"), lambda: self._step(-1)),
        ]
        for key, work in keys:
            key.on_trigger(self._session.click("play", work))
        return [key for key, _ in keys]

    def update(self, frame: Frame) -> None:
        """Shows the newest frame."""
        playing = self._source.playing
        label = "Pause" if playing else "Play"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = Icon.PLAYER_PAUSE if playing else Icon.PLAYER_PLAY
        pace = f"{self._source.pace:g}"
        if pace in self._pace.options:
            assign(self._pace, "value", pace)
        scan = self._source.scan
        if time.monotonic() - self._touched > HOLD:
            assign(self._scan, "value", scan)
        content = _where_html(scan, self._source.scans, frame.time)
        assign(self._where, "content", content)

    def close(self) -> None:
        """Removes the keys."""
        for key in self._keys:
            key.remove()

    def _toggle(self) -> None:
        if self._source.playing:
            self._source.pause()
        else:
            self._source.play()

    def _step(self, scans: int) -> None:
        self._source.pause()
        self._source.seek(self._source.scan + scans)
        self._touched = float("-inf")

    def _seek(self, scan: Any) -> None:
        self._touched = time.monotonic()
        self._source.seek(int(scan))


def _where_html(scan: int, scans: int, seconds: float) -> str:
    return f'<div class="firstlap-where" style="padding:0 0.8em 0.5em">scan {scan} of {scans}, {seconds:.2f} s</div>'
