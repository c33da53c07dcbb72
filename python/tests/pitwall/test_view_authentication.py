"""The pit wall's authentication over real sockets: admission, roles, and refused requests."""

from __future__ import annotations

import contextlib
import http.client
import os
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

import viser
from viewing import Viewer, get, served, wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus

from firstlap.common.errors import InputError
from firstlap.pitwall import guarded_connection
from firstlap.pitwall.authentication import VIEWERS, WATCHERS, Authenticator
from firstlap.pitwall.guarded_connection import Role

TOKEN = "green flag / 1"


class House:
    """A server with a slider for viewers with control, and a list of connected viewers."""

    def __init__(self, authenticator: Authenticator, server: viser.ViserServer) -> None:
        self.authenticator = authenticator
        self.server = server
        self.roles: dict[int, Role] = {}
        self.sliders: dict[int, viser.GuiSliderHandle[float]] = {}
        self.moved: list[float] = []

        @server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            if authenticator.role(client.client_id) is Role.CONTROL:
                slider = client.gui.add_slider("k_ang", 0.0, 1.0, 0.1, 0.5)
                slider.on_update(lambda event: self.moved.append(event.target.value))
                self.sliders[client.client_id] = slider
            self.roles[client.client_id] = authenticator.role(client.client_id)

    def uuid(self, client_id: int) -> str:
        """The value of the slider of a viewer with control."""
        return self.sliders[client_id]._impl.uuid

    @contextlib.contextmanager
    def viewer(self, **how: str) -> Iterator[tuple[Viewer, int]]:
        """Connects a viewer; returns it and its id."""
        before = set(self.roles)
        viewer = Viewer(self.authenticator, **how).enter()
        wait_until(lambda: bool(set(self.roles) - before))
        yield viewer, max(set(self.roles) - before)
        viewer.close()


def house(token: str | None) -> Iterator[House]:
    authenticator = Authenticator(token)
    with served(authenticator) as server:
        yield House(authenticator, server)


@pytest.fixture(scope="module")
def open_house() -> Iterator[House]:
    """A local server, where everybody has control."""
    yield from house(None)


@pytest.fixture(scope="module")
def locked_house() -> Iterator[House]:
    """A server that requires a token."""
    yield from house(TOKEN)


def cookie_from(authenticator: Authenticator, address: str | None) -> str:
    """The response and cookie for an address."""
    assert address is not None
    status, _, headers = get(authenticator, address[address.index("/?") :])
    assert status == 200
    assert "HttpOnly" in headers["Set-Cookie"]
    assert "SameSite=Strict" in headers["Set-Cookie"]
    return headers["Set-Cookie"].partition(";")[0]


def test_on_this_machine_everybody_may_control(open_house: House) -> None:
    assert get(open_house.authenticator)[0] == 200
    assert open_house.authenticator.warning is None
    assert open_house.authenticator.watch_url is None
    with open_house.viewer() as (viewer, number):
        assert open_house.roles[number] is Role.CONTROL
        viewer.update(open_house.uuid(number), 0.7)
        wait_until(lambda: open_house.moved[-1:] == [0.7])


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{port}", "127.0.0.1:1", "localhost.evil:{port}", ""])
def test_a_name_that_a_stranger_points_at_this_machine_is_refused(open_house: House, host: str) -> None:
    status, text, _ = get(open_house.authenticator, Host=host.format(port=open_house.authenticator.port))
    assert status == 403
    assert text.count("\n") == 1


@pytest.mark.parametrize("host", ["localhost:{port}", "127.0.0.1:{port}", "[::1]:{port}", "LOCALHOST:{port}"])
def test_the_names_of_this_machine_are_known(open_house: House, host: str) -> None:
    assert get(open_house.authenticator, Host=host.format(port=open_house.authenticator.port))[0] == 200


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", "null", None])
def test_another_page_gets_no_websocket(open_house: House, origin: str | None) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        Viewer(open_house.authenticator, origin=origin)


def test_no_page_may_put_ours_into_a_frame(open_house: House) -> None:
    _, _, headers = get(open_house.authenticator)
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"


@pytest.mark.parametrize(
    "path", ["/", "/?token=", "/?token=green", "/?token=green+flag+%2F+2", "/index.html", "/a/../b"]
)
def test_a_wrong_token_sees_nothing(locked_house: House, path: str) -> None:
    status, text, headers = get(
        locked_house.authenticator, path, Cookie=f"firstlap_{locked_house.authenticator.port}=guess"
    )
    assert status == 403
    assert text.count("\n") == 1
    assert "token" in text
    assert "Set-Cookie" not in headers
    with pytest.raises(InvalidStatus, match="403"):
        Viewer(locked_house.authenticator, query=path.lstrip("/"))


def test_a_wrong_token_is_not_helped_by_an_old_cookie(locked_house: House) -> None:
    cookie = cookie_from(locked_house.authenticator, locked_house.authenticator.url)
    assert get(locked_house.authenticator, "/", Cookie=cookie)[0] == 200
    assert get(locked_house.authenticator, "/?token=wrong", Cookie=cookie)[0] == 403


@pytest.mark.parametrize("role", list(Role))
def test_the_address_decides_what_its_viewer_may_do(locked_house: House, role: Role) -> None:
    address = locked_house.authenticator.url if role is Role.CONTROL else locked_house.authenticator.watch_url
    with locked_house.viewer(cookie=cookie_from(locked_house.authenticator, address)) as (_, number):
        assert locked_house.roles[number] is role


def test_a_watcher_who_forges_messages_of_a_controller_changes_nothing(locked_house: House) -> None:
    authenticator = locked_house.authenticator
    control, watch = (
        cookie_from(authenticator, authenticator.url),
        cookie_from(authenticator, authenticator.watch_url),
    )
    with locked_house.viewer(cookie=control) as (controller, master), locked_house.viewer(cookie=watch) as (watcher, _):
        uuid = locked_house.uuid(master)
        moved = len(locked_house.moved)
        watcher.update(uuid, 0.9)
        watcher.say(type="GuiUpdateMessage", uuid=uuid, updates={"value": 0.9, "removed": True})
        watcher.say(type="GuiButtonHoldMessage", uuid=uuid, frequency=10.0)
        watcher.say(type="CommandTriggerMessage", uuid=uuid)
        watcher.say(type="GuiFormDirtyMessage", uuid=uuid)
        assert not [message for message in controller.heard(0.2) if message["type"].startswith("GuiForm")]
        assert len(locked_house.moved) == moved
        assert locked_house.sliders[master].value == 0.5
        controller.update(uuid, 0.6)
        wait_until(lambda: locked_house.moved[-1:] == [0.6])


def test_nobody_opens_the_tunnel_of_the_library_to_the_internet(
    open_house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *_: asked.append("tunnel"))
    with open_house.viewer() as (viewer, number):
        viewer.say(type="ShareUrlRequest")
        viewer.say(type="ShareUrlDisconnect")
        viewer.update(open_house.uuid(number), 0.3)
        wait_until(lambda: open_house.moved[-1:] == [0.3])
    assert not asked


@pytest.mark.parametrize(
    "path", ["/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..%5c..%5cetc/passwd", "//etc/passwd"]
)
def test_no_path_leads_out_of_the_page(open_house: House, path: str) -> None:
    status, text, _ = get(open_house.authenticator, path)
    assert status == 404
    assert "root:" not in text


def test_garbage_ends_the_connection_that_sent_it_and_no_other(
    open_house: House, capfd: pytest.CaptureFixture[str]
) -> None:
    with open_house.viewer() as (good, number):
        for raw in (b"\x00" * 50, os.urandom(200), b"GET / HTTP/1.1\r\n\r\n" + b"x" * 100):
            with socket.create_connection(("127.0.0.1", open_house.authenticator.port), timeout=5) as line:
                line.sendall(raw)
                line.shutdown(socket.SHUT_WR)
                with contextlib.suppress(OSError):
                    while line.recv(4096):
                        pass
        for nonsense in (b"\xc1", b"", b"\x91" * 2000, "text"):
            with open_house.viewer() as (viewer, _):
                viewer.connection.send(nonsense)
                with pytest.raises(ConnectionClosed, match="1003"):
                    while True:
                        viewer.connection.recv(timeout=5)
        with open_house.viewer() as (viewer, _):
            viewer.say(type="ViewerCameraMessage", wxyz=None)
            with pytest.raises(ConnectionClosed):
                while True:
                    viewer.connection.recv(timeout=5)
        good.update(open_house.uuid(number), 0.2)
        wait_until(lambda: open_house.moved[-1:] == [0.2])
    assert "Traceback" not in capfd.readouterr().err


def test_a_message_is_bounded(open_house: House) -> None:
    with open_house.viewer() as (viewer, number), pytest.raises(ConnectionClosed, match="1009"):
        viewer.update(open_house.uuid(number), "x" * (guarded_connection.MESSAGE_SIZE + 1))
        while True:
            viewer.connection.recv(timeout=5)


def test_more_viewers_than_there_is_room_for_are_turned_away(
    open_house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_until(lambda: not open_house.authenticator._live)
    monkeypatch.setattr("firstlap.pitwall.authentication.VIEWERS", 2)
    with open_house.viewer(), open_house.viewer(), pytest.raises(InvalidStatus, match="503"):
        Viewer(open_house.authenticator)
    wait_until(lambda: not open_house.authenticator._live)
    with open_house.viewer():
        pass


def test_a_viewer_that_sleeps_is_given_up_and_holds_up_nobody(
    open_house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(guarded_connection, "SEND_TIMEOUT", 0.5)
    server = open_house.server
    _sleeper = Viewer(open_house.authenticator).enter()
    wait_until(lambda: len(server.get_clients()) == 1)
    (handle,) = server.get_clients().values()
    buffer = handle._websock_connection.get_message_buffer()
    text = handle.gui.add_markdown("")
    with open_house.viewer() as (viewer, number):
        longest = 0
        end = time.monotonic() + 10.0
        while sleeper_is_in := handle.client_id in server.get_clients():
            assert time.monotonic() < end
            text.content = os.urandom(100_000).hex()
            longest = max(longest, len(buffer.message_from_id))
            time.sleep(0.005)
        assert not sleeper_is_in
        assert longest < 20
        viewer.update(open_house.uuid(number), 0.1)
        wait_until(lambda: open_house.moved[-1:] == [0.1])


def test_a_taken_port_is_said_and_no_other_is_used(open_house: House) -> None:
    with pytest.raises(InputError, match=f"port {open_house.authenticator.port} is in use"):
        Authenticator().open(port=open_house.authenticator.port)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ({"port": 70000}, "--port: 70000"),
        ({"host": "no.such.host.invalid"}, "--host"),
        ({"host": "192.0.2.1"}, "port 8080 is not available"),
    ],
)
def test_what_cannot_be_listened_on_is_one_line(where: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Authenticator().open(**where)


def test_a_token_that_is_soon_guessed_is_refused() -> None:
    with pytest.raises(InputError, match="the token: expected 8"):
        Authenticator("short")


def test_on_every_address_there_are_two_tokens_and_a_warning() -> None:
    authenticator = Authenticator()
    with served(authenticator, "0.0.0.0"):
        assert not authenticator.loopback
        assert authenticator.warning is not None
        assert get(authenticator)[0] == 403
        cookies = {
            cookie_from(authenticator, authenticator.url),
            cookie_from(authenticator, authenticator.watch_url),
        }
        assert len(cookies) == 2
        assert authenticator.url.startswith("http://")
        assert "0.0.0.0" not in authenticator.url


def test_who_is_at_the_door_when_it_opens_has_his_role(capfd: pytest.CaptureFixture[str]) -> None:
    authenticator = Authenticator()
    with served(authenticator):
        port = authenticator.port
    early: list[Viewer] = []

    def knock() -> None:
        for _ in range(5000):
            with contextlib.suppress(OSError):
                early.append(Viewer(authenticator).enter())
                return

    knocking = threading.Thread(target=knock)
    knocking.start()
    authenticator = Authenticator()
    authenticator.port = port
    with served(authenticator, port=port) as server:
        wait_until(lambda: len(server.get_clients()) == 1)
        assert authenticator.role(next(iter(server.get_clients()))) is Role.CONTROL
        knocking.join()
        early[0].close()
    assert capfd.readouterr().out == ""


def test_a_request_that_never_ends_is_dropped(open_house: House) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", open_house.authenticator.port, timeout=8)
    connection.putrequest("POST", "/")
    connection.endheaders()
    with pytest.raises((http.client.HTTPException, OSError)):
        connection.getresponse()
    connection.close()


def test_watchers_cannot_lock_out_who_controls(locked_house: House) -> None:
    authenticator = locked_house.authenticator
    control, watch = (
        cookie_from(authenticator, authenticator.url),
        cookie_from(authenticator, authenticator.watch_url),
    )
    watchers = [Viewer(authenticator, cookie=watch).enter() for _ in range(WATCHERS)]
    with pytest.raises(InvalidStatus, match="503"):
        Viewer(authenticator, cookie=watch)
    room = VIEWERS - WATCHERS
    # The last one displaces a read-only viewer.
    controllers = [Viewer(authenticator, cookie=control).enter() for _ in range(room + 1)]
    with pytest.raises(ConnectionClosed):
        for _ in range(1000):
            watchers[-1].heard(0.1)
    controllers[-1].heard(0.1)
    watchers[0].heard(0.1)
    for viewer in (*controllers, *watchers[:-1]):
        viewer.close()


def test_who_says_nothing_takes_up_no_place(locked_house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded_connection, "FIRST_MESSAGE_TIMEOUT", 0.3)
    authenticator = locked_house.authenticator
    silent = Viewer(authenticator, cookie=cookie_from(authenticator, authenticator.watch_url))
    with pytest.raises(ConnectionClosed):
        for _ in range(1000):
            silent.heard(0.1)


def test_the_address_that_opens_the_browser_holds_no_token_and_serves_once(locked_house: House) -> None:
    authenticator = locked_house.authenticator
    address = authenticator.opening_url()
    assert "token" not in address
    assert not any(part in address for part in ("green", authenticator.url.partition("=")[2]))
    status, _, headers = get(authenticator, address[address.index("/?") :])
    assert (status, headers["Location"]) == (303, "/")
    cookie = headers["Set-Cookie"].partition(";")[0]
    assert get(authenticator, "/", Cookie=cookie)[0] == 200
    assert get(authenticator, address[address.index("/?") :])[0] == 403
    assert get(authenticator, "/?key=guess")[0] == 403
    assert get(authenticator, "/?key=")[0] == 403
