"""A viser WebSocket with a role: filters and rate-limits its messages, and times out slow browsers."""

from __future__ import annotations

import asyncio
import logging
import math
from enum import Enum
from time import monotonic
from typing import Any

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

MESSAGE_SIZE = 2**20
"""[B] Maximum size of one message from a browser."""
QUEUE = 4
"""Maximum number of unread messages of one browser."""
SEND_TIMEOUT = 10.0
"""[s] Send timeout. websockets' own ping does not help: it waits behind the unsent messages."""
FIRST_MESSAGE_TIMEOUT = 10.0
"""[s] Timeout of the first message. viser's page sends its camera at once; a silent client must not occupy a slot."""
RATE = 200.0
"""[1/s] Sustained message rate of one browser; a page sends some 70 while a control is dragged."""
BURST = 200.0
"""Burst size. A browser that exceeds it is slowed down; others, who might press the emergency stop, are not."""

CAMERA = "ViewerCameraMessage"
_WATCHING = frozenset(
    {
        CAMERA,
        "GuiUpdateMessage",
        "GuiButtonHoldMessage",
        "CommandTriggerMessage",
        "LocalStorageGetItemResponseMessage",
        "GetRenderResponseMessage",
    }
)
_CONTROLLING = _WATCHING | {
    "ScenePointerMessage",
    "SceneNodeClickMessage",
    "SceneNodeDragMessage",
    "TransformControlsUpdateMessage",
    "TransformControlsDragStartMessage",
    "TransformControlsDragEndMessage",
}
"""Allowed messages. Excluded are viser's share link, which would open a tunnel from the internet, uploads, and forms,
which viser forwards unchecked to every browser."""


class Role(Enum):
    """The rights of a viewer."""

    CONTROL = "control"
    WATCH = "watch"


class _Envelope(msgspec.Struct):
    type: str
    updates: dict[str, Any] | msgspec.UnsetType = msgspec.UNSET


_Three = tuple[float, float, float]


class _Camera(msgspec.Struct):
    wxyz: tuple[float, float, float, float]
    position: _Three
    look_at: _Three
    up_direction: _Three
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float

    @property
    def is_valid(self) -> bool:
        numbers = (*self.wxyz, *self.position, *self.look_at, *self.up_direction, self.fov, self.near, self.far)
        sizes = (self.image_height, self.image_width)
        return all(map(math.isfinite, (*numbers, *sizes))) and 0.0 < self.fov < math.pi


_decoder = msgspec.msgpack.Decoder(_Envelope)
_cameras = msgspec.msgpack.Decoder(_Camera)


def may_pass(message: str | bytes, role: Role) -> bool:
    """Whether to forward a message to viser. Raises ValueError if it is not a viser message."""
    if isinstance(message, str):
        raise ValueError("a text message; viser's messages are binary")
    try:
        envelope = _decoder.decode(message)
        if envelope.type == CAMERA and not _cameras.decode(message).is_valid:
            return False
    except (msgspec.MsgspecError, RecursionError) as error:
        raise ValueError(str(error)) from None
    if envelope.type not in (_CONTROLLING if role is Role.CONTROL else _WATCHING):
        return False
    # viser would set any attribute that an update names.
    return envelope.updates is msgspec.UNSET or set(envelope.updates) == {"value"}


class TokenBucket:
    """A token bucket for messages: a burst size and a sustained rate."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._at = burst, 0.0

    def take(self, now: float) -> float:
        """Takes one token at the time `now` [s]; returns the delay [s] before the message may be handled."""
        self._left = min(self._left + (now - self._at) * self._rate, self._burst) - 1.0
        self._at = now
        return max(-self._left / self._rate, 0.0)


class GuardedConnection(ServerConnection):
    """Forwards the messages that its role allows; closes on a send timeout or an invalid message."""

    role = Role.WATCH

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._bucket = TokenBucket(RATE, BURST)
        self._has_received = False

    async def recv(self, decode: bool | None = None) -> Any:
        """The next allowed message. Raises ConnectionClosed, also if none arrives within FIRST_MESSAGE_TIMEOUT."""
        while True:
            message = await (super().recv(decode) if self._has_received else self._first(decode))
            wait = self._bucket.take(monotonic())
            if wait > 0.0:
                await asyncio.sleep(wait)
            try:
                if may_pass(message, self.role):
                    return message
            except ValueError:
                await self.close(1003, "not a viser message")

    async def _first(self, decode: bool | None) -> Any:
        try:
            message = await asyncio.wait_for(super().recv(decode), FIRST_MESSAGE_TIMEOUT)
        except asyncio.TimeoutError:
            await self.close(1008, "no message received")
            return await super().recv(decode)
        self._has_received = True
        return message

    async def send(self, message: Any, text: bool | None = None) -> None:
        """Raises ConnectionClosed, also after the send timeout."""
        try:
            await asyncio.wait_for(super().send(message, text), SEND_TIMEOUT)
        except asyncio.TimeoutError:
            self.transport.abort()
            await self.wait_closed()
            await super().send(message, text)


class Quiet(logging.Logger):
    """A silent logger for websockets: refused and lost connections are not worth printing."""

    def __init__(self) -> None:
        super().__init__("firstlap.pitwall", logging.CRITICAL)


__all__ = ["MESSAGE_SIZE", "QUEUE", "ConnectionClosed", "GuardedConnection", "Quiet", "Role", "may_pass"]
