"""What a browser that comes late is told: what there is now, without a walk over all that ever was.

viser numbers every message that it ever sent, keeps those that still count, and leads each new browser through all
numbers from the first one on, on the thread that also hears the emergency stop: after ten hours, for seconds.
"""

from __future__ import annotations

from typing import Any

import viser


def skip_what_is_gone(server: viser.ViserServer) -> None:
    """From now on who joins is led through the messages that are still there, and then through all new ones."""
    buffer = server._websock_server._broadcast_buffer
    walk = type(buffer).window_generator

    def window_generator(client_id: int, backlog_done_message: Any = None) -> Any:
        return walk(_Renumbered(buffer), client_id, backlog_done_message)  # type: ignore[arg-type]

    buffer.window_generator = window_generator  # type: ignore[method-assign]


class _Renumbered:
    """A buffer as one browser sees it: what is there when it comes has the numbers from 0 on, all else follows."""

    def __init__(self, buffer: Any) -> None:
        self._buffer = buffer
        self._kind = type(buffer)
        with buffer.buffer_lock:
            self._kept = sorted(buffer.message_from_id)
            self._first_new = buffer.message_counter
        self.message_from_id = _Messages(self)
        self.generator_cursors = _Cursors(self)

    def __getattr__(self, name: str) -> Any:
        if name == "_window_loop":
            return self._kind._window_loop.__get__(self)
        return getattr(self._buffer, name)

    @property
    def message_counter(self) -> int:
        """How many this browser is led through so far."""
        return len(self._kept) + int(self._buffer.message_counter) - self._first_new

    def theirs(self, number: int) -> int:
        """The buffer's number of a message."""
        if number < 0:
            return -1
        return self._kept[number] if number < len(self._kept) else self._first_new + number - len(self._kept)


class _Messages:
    def __init__(self, seen: _Renumbered) -> None:
        self._seen = seen

    def get(self, number: int, default: Any = None) -> Any:
        return self._seen._buffer.message_from_id.get(self._seen.theirs(number), default)


class _Cursors:
    """How far the browser is, told in the buffer's numbers: nothing is forgotten before it was taken."""

    def __init__(self, seen: _Renumbered) -> None:
        self._seen = seen

    def __setitem__(self, client_id: int, number: int) -> None:
        self._seen._buffer.generator_cursors[client_id] = self._seen.theirs(number)

    def pop(self, client_id: int, default: Any = None) -> Any:
        return self._seen._buffer.generator_cursors.pop(client_id, default)
