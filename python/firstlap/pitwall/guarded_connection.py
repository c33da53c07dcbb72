"""A websocket of viser's that knows who is at its other end: what it may say, and how long it may keep us waiting."""

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
"""[B] of one message from a browser."""
QUEUE = 4
"""Messages of one browser that wait to be read."""
PATIENCE = 10.0
"""[s] that a browser may take none of what it is sent. websockets' own ping waits behind what is not taken."""
FIRST_MESSAGE = 10.0
"""[s] within which a page says where it looks from, as viser's does at once; who says nothing takes up no place."""
RATE = 200.0
"""[1/s] Messages that are taken of one browser in the long run; a page sends some 70 while everything is dragged."""
BURST = 200.0
"""Messages at once. One that says more is listened to more slowly, and others, who might press the stop, are not."""

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
"""Messages that are passed on. Not among them: viser's share link, which would open a tunnel to us from the internet,
uploads, and forms, which viser passes on to every browser unread."""


class Role(Enum):
    """What a viewer may do."""

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
    def can_be(self) -> bool:
        numbers = (*self.wxyz, *self.position, *self.look_at, *self.up_direction, self.fov, self.near, self.far)
        sizes = (self.image_height, self.image_width)
        return all(map(math.isfinite, (*numbers, *sizes))) and 0.0 < self.fov < math.pi


_decoder = msgspec.msgpack.Decoder(_Envelope)
_cameras = msgspec.msgpack.Decoder(_Camera)


def may_pass(message: str | bytes, role: Role) -> bool:
    """Whether a message goes on to viser. Raises ValueError where it is none of viser's."""
    if isinstance(message, str):
        raise ValueError("text, where viser's messages are binary")
    try:
        envelope = _decoder.decode(message)
        if envelope.type == CAMERA and not _cameras.decode(message).can_be:
            return False
    except (msgspec.MsgspecError, RecursionError) as error:
        raise ValueError(str(error)) from None
    if envelope.type not in (_CONTROLLING if role is Role.CONTROL else _WATCHING):
        return False
    # viser sets whatever attribute an update names.
    return envelope.updates is msgspec.UNSET or set(envelope.updates) == {"value"}


class Allowance:
    """Of messages: so many at once, so many in the long run."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._at = burst, 0.0

    def take(self, now: float) -> float:
        """One more at that time [s]: the time [s] to wait before it counts."""
        self._left = min(self._left + (now - self._at) * self._rate, self._burst) - 1.0
        self._at = now
        return max(-self._left / self._rate, 0.0)


class GuardedConnection(ServerConnection):
    """Passes on what its role may say; gives up on a browser that takes nothing, and on one that talks nonsense."""

    role = Role.WATCH

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._allowance = Allowance(RATE, BURST)
        self._has_spoken = False

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that may pass. Raises ConnectionClosed, also where none came within FIRST_MESSAGE."""
        while True:
            message = await (super().recv(decode) if self._has_spoken else self._first(decode))
            wait = self._allowance.take(monotonic())
            if wait > 0.0:
                await asyncio.sleep(wait)
            try:
                if may_pass(message, self.role):
                    return message
            except ValueError:
                await self.close(1003, "not a message of this page")

    async def _first(self, decode: bool | None) -> Any:
        try:
            message = await asyncio.wait_for(super().recv(decode), FIRST_MESSAGE)
        except asyncio.TimeoutError:
            await self.close(1008, "nothing was said")
            return await super().recv(decode)
        self._has_spoken = True
        return message

    async def send(self, message: Any, text: bool | None = None) -> None:
        """Raises ConnectionClosed, also where nothing was taken for PATIENCE."""
        try:
            await asyncio.wait_for(super().send(message, text), PATIENCE)
        except asyncio.TimeoutError:
            self.transport.abort()
            await self.wait_closed()
            await super().send(message, text)


class Quiet(logging.Logger):
    """For websockets: strangers knocking, and connections lost, are nothing to print."""

    def __init__(self) -> None:
        super().__init__("firstlap.pitwall", logging.CRITICAL)


__all__ = ["MESSAGE_SIZE", "QUEUE", "ConnectionClosed", "GuardedConnection", "Quiet", "Role", "may_pass"]
