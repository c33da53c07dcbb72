"""The pit wall in a real browser."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from sight import Sight, near

from firstlap.car_file import load_car
from firstlap.colours import LEFT, LINE, RIGHT, rgb
from firstlap.setup_file import load_setup
from firstlap.tracks.library import load_track
from firstlap.view.app import App, serve
from firstlap.view.gate import Gate
from firstlap.view.panel import Panel, WatchPanel
from firstlap.view.sim_source import SimSource
from firstlap.view.source import Source

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
WAIT = 15.0


def wall(source: Source, token: str | None = None) -> tuple[Gate, App]:
    """As `firstlap view` puts it together."""

    def panel(client: Any, may_control: bool, on_map: Any) -> Any:
        return Panel(client, source, on_map=on_map) if may_control else WatchPanel(client, source)

    gate = Gate(token)
    return gate, serve(source, port=0, gate=gate, panel=panel)


class Pit:
    """A race before the browser."""

    def __init__(self, browser: Browser, token: str | None = None) -> None:
        self.browser = browser
        self.source = SimSource(load_track("oval"), load_setup("sure"), load_car("default"))
        self.source.start()
        self.gate, self.app = wall(self.source, token)

    def close(self) -> None:
        """And the race."""
        self.app.close()
        self.source.close()

    def see(self, fine: float = 0.3) -> Sight:
        """Another viewer."""
        return Sight(self.browser, self.gate.url, fine=fine).ready()


@pytest.fixture(scope="module")
def whole_pit(browser: Browser) -> Iterator[tuple[Pit, Sight]]:
    """One race, one viewer."""
    pit = Pit(browser)
    sight = pit.see(1.0)
    yield pit, sight
    sight.close()
    pit.close()


@pytest.fixture
def pit(whole_pit: tuple[Pit, Sight]) -> Pit:
    """The race, as it was loaded."""
    pit = whole_pit[0]
    pit.source.choose(pit.source.loaded)
    pit.source.go()
    pit.source.restart()
    return pit


@pytest.fixture
def sight(pit: Pit, whole_pit: tuple[Pit, Sight]) -> Sight:
    """What its viewer sees."""
    sight = whole_pit[1]
    sight.until(lambda: "STOPPED" not in sight.text())
    return sight


def test_the_page_comes_up_with_points_by_side_path_and_car(sight: Sight) -> None:
    sight.page.wait_for_timeout(1500)
    picture = sight.picture("race")
    middle = picture[:, 400:720]
    assert near(middle, rgb(LEFT)) > 100
    assert near(middle, rgb(RIGHT)) > 100
    assert near(middle, rgb(LINE)) > 50
    path = [(r, g, b) for r, g, b in ((70, 130, 250), (40, 190, 230), (26, 228, 182), (70, 250, 110))]
    assert sum(near(middle, colour, 60) for colour in path) > 100


def test_frames_go_on_coming_with_1081_beams(pit: Pit, sight: Sight, capsys: pytest.CaptureFixture[str]) -> None:
    assert pit.source.car.core.values()["lidar"]["beams"] == 1081
    moment, shown, drawn, begin = sight.moment(), sight.count("shown"), sight.count("drawn"), time.monotonic()
    sight.page.wait_for_timeout(2000)
    seconds = time.monotonic() - begin
    shown, drawn = sight.count("shown") - shown, sight.count("drawn") - drawn
    with capsys.disabled():
        print(
            f"\n1081 beams: {pit.app.updates:.0f} frames a second shown by the server, {shown / seconds:.0f} batches a "
            f"second reached the page, {drawn / seconds:.0f} pictures a second drawn"
        )
    assert shown > 4
    assert sight.moment() != moment


def test_a_slider_changes_the_running_car_and_the_laps_that_follow(pit: Pit, sight: Sight) -> None:
    pit.source.set_condition("view.pace", 8.0)
    sight.until(lambda: len(laps(pit)) >= 2, 40.0)
    before = laps(pit)[1].time
    sight.slide("v_max", 0.08)
    sight.until(lambda: 1.2 < float(pit.source.setup.get("v_max")) < 2.2)
    slow = float(pit.source.setup.get("v_max"))
    done = len(laps(pit))
    sight.until(lambda: len(laps(pit)) >= done + 2, 60.0)
    after = laps(pit)[-1]
    assert after.time > 1.2 * before
    assert after.speed.max() < slow + 0.3
    assert f"{slow:g}" in sight.box("v_max").input_value()
    pit.source.set_condition("view.pace", 1.0)


def laps(pit: Pit) -> Any:
    frame = pit.source.latest()
    return frame.laps if frame else ()


def test_an_impossible_value_is_refused_visibly(pit: Pit, sight: Sight) -> None:
    before = pit.source.setup
    box = sight.box("v_max")
    said = box.input_value()
    box.fill("99")
    sight.page.get_by_text("outside of what is allowed").first.wait_for()
    sight.picture("refused")
    sight.until(lambda: box.input_value() == said)
    assert pit.source.setup.values() == before.values()


@pytest.mark.parametrize("how", ["button", "key"])
def test_the_emergency_stop_stops_the_car_within_0_3_s(pit: Pit, sight: Sight, how: str) -> None:
    sight.until(lambda: pit.source.latest().speed > 1.0)
    sight.page.mouse.click(500, 700)
    begin = time.monotonic()
    if how == "button":
        sight.press("EMERGENCY STOP")
    else:
        sight.page.keyboard.press("Space")
    while pit.source.latest().going:
        assert time.monotonic() - begin < 5.0
        time.sleep(0.002)
    reached = time.monotonic() - begin
    sight.until(lambda: abs(pit.source.latest().speed) < 0.05)
    stood = time.monotonic() - begin
    print(f"{how}: reached the car after {reached:.3f} s, which stood after {stood:.3f} s")
    assert reached < 0.3
    sight.until(lambda: "STOPPED" in sight.text())
    sight.picture("stopped")
    way = pit.source.latest().way
    sight.page.wait_for_timeout(300)
    assert pit.source.latest().way == pytest.approx(way, abs=0.02)
    sight.page.wait_for_timeout(400)
    sight.press("Go")
    sight.until(lambda: pit.source.latest().speed > 0.5)


def test_two_viewers_see_the_same_and_what_the_other_changes(pit: Pit, sight: Sight) -> None:
    other = pit.see()
    try:
        sight.box("k_dist").fill("0.77")
        sight.until(lambda: pit.source.setup.get("k_dist") == 0.77)
        other.until(lambda: other.box("k_dist").input_value() == "0.77")
        other.page.keyboard.press("Escape")
        sight.until(lambda: "STOPPED" in sight.text())
    finally:
        other.close()


def test_reload_and_a_lost_connection_bring_back_what_drives(pit: Pit, sight: Sight) -> None:
    pit.source.change({"k_dist": 0.66})
    sight.page.reload()
    sight.ready()
    sight.until(lambda: sight.box("k_dist").input_value() == "0.66")
    pit.app._server._websock_server.disconnect_all_clients()
    sight.until(lambda: not sight.connected)
    pit.source.change({"k_dist": 0.55})
    sight.until(lambda: sight.connected)
    sight.until(lambda: sight.box("k_dist").input_value() == "0.55")
    moment = sight.moment()
    sight.until(lambda: sight.moment() not in (None, moment))


def test_a_wrong_token_sees_nothing_and_a_watcher_has_no_controls(browser: Browser) -> None:
    pit = Pit(browser, "green flag 1")
    try:
        stranger = Sight(browser, f"http://127.0.0.1:{pit.app.port}/?token=red+flag")
        assert "token" in stranger.text()
        assert stranger.page.locator("canvas").count() == 0
        stranger.close()
        assert pit.gate.watch_url is not None
        watcher = Sight(browser, pit.gate.watch_url).ready()
        watcher.page.keyboard.press("Space")
        watcher.page.wait_for_timeout(300)
        assert "EMERGENCY STOP" not in watcher.text()
        assert "watching" in watcher.text()
        assert watcher.page.locator("input[inputmode]").count() == 0
        watcher.picture("watching")
        assert pit.source.latest().going
        watcher.close()
    finally:
        pit.close()


def test_a_recording_is_paused_stepped_and_planned_anew(browser: Browser, cli: Any, tmp_path: Path) -> None:
    from firstlap.recordings import load_recording
    from firstlap.view.recording_source import RecordingSource

    assert cli("race", "oval", "--laps", "1", "--record", tmp_path / "lap.mcap").code == 0
    source = RecordingSource(load_recording(tmp_path / "lap.mcap"), load_setup("sure"), load_car("default"))
    source.start()
    gate, app = wall(source)
    sight = Sight(browser, gate.url)
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
    """The command itself."""
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
