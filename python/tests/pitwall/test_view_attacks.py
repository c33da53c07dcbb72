"""The pit wall under attack: floods, invalid messages, a hanging race, browsers that connect after hours."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from command_result import CommandResult
from viewing import CAMERA, Viewer, get, served, wait_until

import firstlap
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.pitwall import sim_source
from firstlap.pitwall.app import serve
from firstlap.pitwall.authentication import Authenticator, ErrorLog
from firstlap.pitwall.camera import aspect_of
from firstlap.pitwall.frame import Frame, Scenery
from firstlap.pitwall.guarded_connection import BURST, RATE, Role, TokenBucket, may_pass
from firstlap.pitwall.mailbox import Mailbox
from firstlap.pitwall.recording_source import Planner, RecordingSource
from firstlap.pitwall.sim_source import SimSource, scenery_of
from firstlap.recordings import load_recording

EVER = 300_000
"""Number of messages sent before a browser connects."""


class Counted(dict[int, Any]):
    """Counts the lookups in a buffer's messages."""

    looked = 0

    def get(self, key: int, default: Any = None) -> Any:
        self.looked += 1
        return super().get(key, default)


def test_who_comes_late_is_led_through_what_there_is_and_not_through_all_that_was() -> None:
    authenticator = Authenticator()
    with served(authenticator) as server:
        frame = server.scene.add_frame("/car", show_axes=False)
        buffer = server._websock_server._broadcast_buffer
        buffer.message_counter = EVER
        frame.position = (1.0, 0.0, 0.0)
        buffer.message_from_id = counted = Counted(buffer.message_from_id)
        viewer = Viewer(authenticator).enter()
        messages = viewer.heard(0.5)
        frame.position = (2.0, 0.0, 0.0)
        messages += viewer.heard(0.5)
        floor = min(buffer.generator_cursors.values())
        viewer.close()
    kinds = [message["type"] for message in messages]
    places = [message["position"][0] for message in messages if message["type"] == "SetPositionMessage"]
    assert kinds.index("ReplayDoneMessage") < len(kinds) - 1
    assert places == [1.0, 2.0]
    assert counted.looked < 200
    assert floor == EVER + 1, "what was taken is told in the buffer's own numbers"


def test_a_browser_is_heard_so_often_and_no_oftener() -> None:
    bucket = TokenBucket(10.0, 3.0)
    assert [bucket.take(5.0) for _ in range(5)] == pytest.approx([0.0, 0.0, 0.0, 0.1, 0.2])
    assert bucket.take(5.31) == 0.0
    assert [bucket.take(99.0) for _ in range(4)] == pytest.approx([0.0, 0.0, 0.0, 0.1])


def test_a_flood_of_one_browser_is_slowed_down_and_another_is_heard_at_once() -> None:
    authenticator, moved, pressed = Authenticator(), [0], threading.Event()
    with served(authenticator) as server:
        slider = server.gui.add_slider("k_ang", 0.0, 1.0, 0.1, 0.5)
        button = server.gui.add_button("stop")

        @slider.on_update
        async def _(_event: object) -> None:
            moved[0] += 1

        @button.on_click
        async def _(_event: object) -> None:
            pressed.set()

        flood, other = Viewer(authenticator).enter(), Viewer(authenticator).enter()
        began = time.monotonic()
        for i in range(int(BURST) + 400):
            flood.update(slider._impl.uuid, 0.1 * (i % 10))
        other.update(button._impl.uuid, True)
        assert pressed.wait(5.0)
        wait_until(lambda: moved[0] >= BURST)
        time.sleep(0.2)
        assert moved[0] <= BURST + RATE * (time.monotonic() - began) + 1.0
        flood.close()
        other.close()


def test_nonsense_is_said_once_and_much_of_it_in_few_lines(capsys: pytest.CaptureFixture[str]) -> None:
    errors = ErrorLog()
    for _ in range(100):
        errors.report(ValueError("not a number\nat all"))
    assert capsys.readouterr().err == "view: ValueError: not a number at all\n"
    for i in range(1000):
        errors.report(ValueError(f"number {i}"))
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == ErrorLog.KEPT
    assert lines[-1] == "view: further errors are not shown"


def test_what_a_race_is_told_waits_for_it_and_holds_nobody_up() -> None:
    ours, theirs = multiprocessing.Pipe()
    box = Mailbox(ours)
    big = b"x" * 100_000
    for i in range(200):  # 20 MB, much more than a pipe's buffer
        box.put(("setup", i, big))
        box.put(("condition", "friction", i))
        box.put(("condition", "pace", i))
    box.put(("stop",))
    heard = []
    while not heard or heard[-1][0] != "stop":
        assert theirs.poll(5.0)
        heard.append(theirs.recv())
    assert heard[-4][:2] == ("setup", 199)
    assert heard[-3:] == [("condition", "friction", 199), ("condition", "pace", 199), ("stop",)]
    assert len(heard) < 100
    box.put(("close",))


@pytest.fixture
def race(arena: firstlap.Track, monkeypatch: pytest.MonkeyPatch) -> Iterator[SimSource]:
    """A running race with a short response timeout."""
    monkeypatch.setattr(sim_source, "RESPONSE_TIMEOUT", 0.4)
    source = SimSource(arena, load_setup("sure"), load_car("default"))
    source.start()
    wait_until(lambda: (frame := source.latest()) is not None and frame.speed > 0.1, 20.0)
    yield source
    source.close()


def test_a_race_that_hangs_is_no_race_that_drives_and_restart_begins_another(race: SimSource) -> None:
    hung = race._race
    assert hung is not None and hung.process.pid is not None
    os.kill(hung.process.pid, signal.SIGSTOP)
    wait_until(lambda: "does not respond: restart" in race.latest().message)  # type: ignore[union-attr]
    assert not race.latest().may_drive, "nobody may read that it drives"  # type: ignore[union-attr]
    began = time.monotonic()
    for i in range(800):  # more than a pipe's buffer
        race.change({"velocity_profile.v_max": 3.0 + 0.001 * i})
        race.set_condition("world.mu_scale", 1.0 - 0.0001 * i)
    race.stop()
    race.go()
    assert time.monotonic() - began < 20.0
    race.restart()
    assert not hung.process.is_alive()
    wait_until(lambda: race.latest().may_drive and race.latest().speed > 0.1, 20.0)  # type: ignore[union-attr]
    assert race.setup.get("velocity_profile.v_max") == pytest.approx(3.799)
    assert multiprocessing.active_children() == [race._race.process]  # type: ignore[union-attr]


class StandIn:
    """A source whose map arrives late. setup, car: of a race that is not driven."""

    def __init__(self) -> None:
        self.title, self.car, self.scenery = "stand-in", load_car("default"), Scenery()
        self.setup = self.loaded = load_setup("sure")

    def latest(self) -> Frame | None:
        """Does nothing."""
        return None


def test_a_map_that_comes_late_is_drawn_and_another_one_takes_its_place(arena: firstlap.Track) -> None:
    source, authenticator = StandIn(), Authenticator()
    app = serve(source, port=0, authenticator=authenticator)  # type: ignore[arg-type]
    try:
        viewer = Viewer(authenticator).enter()
        assert not fences(viewer.heard(0.5))
        for track in (arena, arena.reversed()):
            source.scenery = scenery_of(track)
            assert len(fences(viewer.heard(0.6))) == 1
        source.scenery = Scenery()
        gone = [m["name"] for m in viewer.heard(0.6) if m["type"] == "RemoveSceneNodeMessage"]
        assert gone == ["/map/walls/fence"]
        source.scenery = scenery_of(arena)
        viewer.heard(0.5)
        late = Viewer(authenticator).enter()
        assert len(fences(late.heard(0.6))) == 1, "who comes later sees the map of now, once"
        late.close()
        viewer.close()
    finally:
        app.close()


def fences(messages: list[dict[str, Any]]) -> list[str]:
    """Names of the walls created by these messages."""
    return [m["name"] for m in messages if m["type"] == "MeshMessage" and m["name"].endswith("/walls/fence")]


def test_who_asked_for_a_name_of_this_machine_may_use_it() -> None:
    authenticator = Authenticator()
    with served(authenticator, "localhost"):
        authenticator.host = "pit-wall"  # as if it were given by --host and in the hosts file
        assert get(authenticator, Host=f"pit-wall:{authenticator.port}")[0] == 200
        assert get(authenticator, Host=f"PIT-WALL:{authenticator.port}")[0] == 200
        assert get(authenticator, Host=f"other:{authenticator.port}")[0] == 403
        authenticator.host = "*"
        assert "*" not in authenticator.url


@pytest.mark.parametrize("token", ["", "short", "new\nline here", "x" * 201])
def test_a_token_is_neither_short_nor_long_nor_unprintable(token: str) -> None:
    with pytest.raises(InputError, match="8 to 200 printable"):
        Authenticator(token)


def test_a_namespace_is_for_ros_only(cli: Callable[..., CommandResult]) -> None:
    ran = cli("view", "arena", "--namespace", "car1", "--no-open")
    assert ran.code == 2
    assert "--namespace: has no effect without --ros" in ran.err


@pytest.mark.parametrize("name", ["a b", "../car", "1car", "car1//x", "k\u00e4fer", "/"])
def test_a_namespace_that_ros_would_not_take_is_said_before_ros_starts(
    cli: Callable[..., CommandResult], name: str
) -> None:
    ran = cli("view", "--ros", "--namespace", name, "--no-open")
    assert ran.code == 2
    assert ran.err.startswith("error: --namespace: ")


@pytest.fixture
def played(tmp_path: Path) -> Iterator[RecordingSource]:
    """A recording of a lap of oval."""
    path = tmp_path / "race.mcap"
    firstlap.race(firstlap.load_track("oval"), "sure", laps=1, record=path)
    source = RecordingSource(load_recording(path), load_setup("sure"), load_car("default"))
    yield source
    source.close()


def test_a_scan_that_cannot_be_shown_is_said_and_the_others_are_shown(
    played: RecordingSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = Planner.show

    def show(planner: Planner, scan: int) -> None:
        if scan == 7:
            raise RuntimeError("a driver's mistake")
        before(planner, scan)

    monkeypatch.setattr(Planner, "show", show)
    played.start()
    wait_until(lambda: (frame := played.latest()) is not None and "scan 7 cannot be shown" in frame.message)
    assert not played.playing
    played.seek(20)
    wait_until(lambda: (frame := played.latest()) is not None and not frame.message and "path" in frame.trace)


def test_a_recording_without_scans_is_refused(played: RecordingSource) -> None:
    with pytest.raises(InputError, match="has no scans"):
        RecordingSource(played.recording.first(0), load_setup("sure"), load_car("default"))


@pytest.mark.parametrize(
    "wrong",
    [
        {"fov": math.nan},
        {"fov": 0.0},
        {"position": [math.nan] * 3},
        {"up_direction": [0.0, math.inf, 0.0]},
        {"up_direction": []},
        {"position": "abc"},
        {"image_width": math.nan},
    ],
)
def test_a_camera_that_cannot_be_reaches_nobody(wrong: dict[str, Any]) -> None:
    for role in Role:
        assert may_pass(msgspec.msgpack.encode(CAMERA), role)
        try:
            assert not may_pass(msgspec.msgpack.encode(CAMERA | wrong), role)
        except ValueError as error:
            assert str(error)


def test_a_page_without_height_still_has_an_overview() -> None:
    camera: Any = SimpleNamespace(image_width=800, image_height=0)
    assert aspect_of(camera) == 1.0
    camera.image_height = 400
    assert aspect_of(camera) == 2.0
