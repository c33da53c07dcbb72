"""Replays the current state to a browser that connects late, without iterating over all old messages.

viser numbers every message that it ever sent and keeps the current ones. For each new browser it iterates over all
numbers from the first one on, in the thread that also receives the emergency stop: after ten hours, that takes seconds.
"""

from __future__ import annotations

from typing import Any

import viser


def skip_obsolete_messages(server: viser.ViserServer) -> None:
    """New browsers get the messages that are still kept, and then all new ones."""
    buffer = server._websock_server._broadcast_buffer
    walk = type(buffer).window_generator

    def window_generator(client_id: int, backlog_done_message: Any = None) -> Any:
        return walk(_Renumbered(buffer), client_id, backlog_done_message)  # type: ignore[arg-type]

    buffer.window_generator = window_generator  # type: ignore[method-assign]


class _Renumbered:
    """A view of the buffer for one browser: kept messages are renumbered from 0, new ones follow."""

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
        """Number of messages for this browser so far."""
        return len(self._kept) + int(self._buffer.message_counter) - self._first_new

    def buffer_number(self, number: int) -> int:
        """Converts a number of this view to the buffer's."""
        if number < 0:
            return -1
        return self._kept[number] if number < len(self._kept) else self._first_new + number - len(self._kept)


class _Messages:
    def __init__(self, view: _Renumbered) -> None:
        self._view = view

    def get(self, number: int, default: Any = None) -> Any:
        return self._view._buffer.message_from_id.get(self._view.buffer_number(number), default)


class _Cursors:
    """The browser's position in the buffer's numbers, so that no message is dropped before it was sent."""

    def __init__(self, view: _Renumbered) -> None:
        self._view = view

    def __setitem__(self, client_id: int, number: int) -> None:
        self._view._buffer.generator_cursors[client_id] = self._view.buffer_number(number)

    def pop(self, client_id: int, default: Any = None) -> Any:
        return self._view._buffer.generator_cursors.pop(client_id, default)
