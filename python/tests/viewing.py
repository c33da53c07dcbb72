"""A viewer without a browser: talks to the pit wall over a real WebSocket like its page."""

from __future__ import annotations

import contextlib
import http.client
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import viser
import zstandard
from websockets.sync.client import ClientConnection, connect

from firstlap.pitwall.authentication import Authenticator, silenced

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, 9.0],
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}


@contextlib.contextmanager
def served(authenticator: Authenticator, host: str = "127.0.0.1", port: int = 0) -> Iterator[viser.ViserServer]:
    """A server behind its authenticator."""
    server = authenticator.open(host, port)
    try:
        yield server
    finally:
        with silenced():
            server.stop()


def get(authenticator: Authenticator, path: str = "/", **headers: str) -> tuple[int, str, dict[str, str]]:
    """Status, text and headers of a page; Host=... replaces that header."""
    connection = http.client.HTTPConnection("127.0.0.1", authenticator.port, timeout=5)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    response = connection.getresponse()
    text = response.read().decode("utf-8", "replace")
    connection.close()
    return response.status, text, dict(response.headers)


class Viewer:
    """A connected viewer."""

    def __init__(
        self, authenticator: Authenticator, cookie: str = "", origin: str | None = "", query: str = ""
    ) -> None:
        self.page = f"127.0.0.1:{authenticator.port}"
        self.connection: ClientConnection = connect(
            f"ws://{self.page}/{query}",
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            origin=f"http://{self.page}" if origin == "" else origin,  # type: ignore[arg-type]
            additional_headers={"Cookie": cookie} if cookie else None,
            max_size=None,
            compression=None,
            open_timeout=5,
            close_timeout=1,
        )

    def say(self, **message: Any) -> None:
        """Sends a message, packed like viser's client."""
        self.connection.send(msgspec.msgpack.encode(message))

    def enter(self) -> Viewer:
        """Sends the first camera, from which on viser counts the viewer."""
        self.say(**CAMERA)
        return self

    def update(self, uuid: str, value: object) -> None:
        """Changes the value of a control."""
        self.say(type="GuiUpdateMessage", uuid=uuid, updates={"value": value})

    def heard(self, seconds: float) -> list[dict[str, Any]]:
        """The messages received within that time."""
        messages: list[dict[str, Any]] = []
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try:
                raw = self.connection.recv(timeout=left)
            except TimeoutError:
                break
            assert isinstance(raw, bytes)
            size = int.from_bytes(raw[8:16], "little")
            text = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size], int.from_bytes(raw[:8], "little"))
            messages += msgspec.msgpack.decode(text)["messages"]
        return messages

    def close(self) -> None:
        """Disconnects."""
        self.connection.close()


def wait_until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Waits for a condition. Raises AssertionError on a timeout."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)
