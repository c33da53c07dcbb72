"""The pit wall in a real browser: unauthorized and read-only viewers, a recording, and an ended command."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from sight import Sight, wall

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.pitwall.sim_source import SimSource
from firstlap.tracks.library import load_track

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
WAIT = 90.0


def test_a_wrong_token_sees_nothing_and_a_watcher_has_no_controls(browser: Browser) -> None:
    source = SimSource(load_track("oval"), load_setup("sure"), load_car("default"))
    source.start()
    authenticator, app = wall(source, "green flag 1")
    try:
        stranger = Sight(browser, f"http://127.0.0.1:{authenticator.port}/?token=red+flag")
        assert "token" in stranger.text()
        assert stranger.page.locator("canvas").count() == 0
        stranger.close()
        assert authenticator.watch_url is not None
        watcher = Sight(browser, authenticator.watch_url).ready()
        watcher.page.keyboard.press("Space")
        watcher.page.wait_for_timeout(300)
        assert "EMERGENCY STOP" not in watcher.text()
        watcher.until(lambda: "watching" in watcher.text())
        assert watcher.page.locator("input[inputmode]").count() == 0
        watcher.picture("watching")
        assert source.latest().may_drive
        watcher.close()
    finally:
        app.close()
        source.close()


def test_on_a_phone_the_emergency_stop_is_seen_without_scrolling(browser: Browser) -> None:
    source = SimSource(load_track("oval"), load_setup("sure"), load_car("default"))
    source.start()
    authenticator, app = wall(source)
    try:
        phone = Sight(browser, authenticator.url, 400, 800).ready()
        seen = phone.page.get_by_role("button", name="EMERGENCY STOP").first.bounding_box()
        assert seen is not None
        assert seen["y"] + seen["height"] < 800.0
        phone.press("EMERGENCY STOP")
        phone.until(lambda: not source.latest().may_drive)
        phone.picture("phone")
        phone.close()
        session = Sight(browser, authenticator.url).ready()
        session.until(lambda: session.page.get_by_role("button", name="EMERGENCY STOP").count() == 1)
        session.close()
    finally:
        app.close()
        source.close()


def test_a_recording_is_paused_stepped_and_planned_anew(browser: Browser, cli: Any, tmp_path: Path) -> None:
    from firstlap.pitwall.recording_source import RecordingSource
    from firstlap.recordings import load_recording

    assert cli("race", "oval", "--laps", "1", "--record", tmp_path / "lap.mcap").code == 0
    source = RecordingSource(load_recording(tmp_path / "lap.mcap"), load_setup("sure"), load_car("default"))
    source.start()
    authenticator, app = wall(source)
    sight = Sight(browser, authenticator.url)
    try:
        where = re.compile(r"scan (\d+) of (\d+)")
        sight.until(lambda: where.search(sight.text()))

        def scan() -> int:
            found = where.search(sight.text())
            assert found
            return int(found[1])

        if source.playing:
            sight.press("Pause")
        sight.until(lambda: not source.playing)
        source.seek(100)
        sight.until(lambda: scan() == 100)
        sight.press("+10")
        sight.until(lambda: scan() == 110)
        sight.page.wait_for_timeout(100)
        sight.press("-1")
        sight.until(lambda: scan() == 109)
        before = source.latest().trace
        sight.box("v_max").fill("1.5")
        sight.until(lambda: source.setup.get("v_max") == 1.5)
        sight.until(lambda: source.latest().trace is not before)
        assert scan() == 109
        sight.picture("recording")
        sight.press("Play")
        sight.until(lambda: scan() > 120)
    finally:
        sight.close()
        app.close()
        source.close()


def start(port: int, folder: Path) -> subprocess.Popen[str]:
    """Runs the command."""
    script = "from firstlap_command import main; main()"
    arguments = ["view", "oval", "--port", str(port), "--no-open"]
    process = subprocess.Popen(
        [sys.executable, "-c", script, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == f"http://127.0.0.1:{port}/\n"
    return process


def test_a_server_that_was_killed_and_started_again_is_found_again(browser: Browser, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    process = start(port, tmp_path)
    sight = Sight(browser, f"http://127.0.0.1:{port}/")
    try:
        sight.ready().until(lambda: (sight.moment() or 0.0) > 1.0)
        process.kill()
        process.communicate(timeout=WAIT)
        sight.until(lambda: not sight.connected)
        process = start(port, tmp_path)
        sight.until(lambda: sight.connected, 30.0)
        sight.until(lambda: (sight.moment() or 0.0) > 0.5)
        sight.press("EMERGENCY STOP")
        sight.until(lambda: "STOPPED" in sight.text())
    finally:
        sight.close()
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=WAIT)
    assert process.returncode == 0
    assert "Traceback" not in error
