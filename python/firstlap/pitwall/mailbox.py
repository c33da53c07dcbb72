"""Messages to the race process, sent by a separate thread so that no caller waits for an unresponsive race."""

from __future__ import annotations

import threading
from multiprocessing.connection import Connection
from typing import Any

CLOSE = "close"
OF_ONE_KEY = ("condition",)
"""Kinds of messages that are distinguished by their second item."""

Message = tuple[Any, ...]


class Mailbox:
    """Queues only the newest message of each kind, in order of arrival. A blocked race gets the current position of a
    slider, not its history, and memory stays bounded."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._waiting: dict[Message, Message] = {}
        self._there = threading.Condition()
        threading.Thread(target=self._run, name="mailbox", daemon=True).start()

    def put(self, message: Message) -> None:
        """Queues a message. Never blocks. Messages to an ended race are dropped; after ("close",) nothing more is
        sent."""
        kind = message[: 2 if message[0] in OF_ONE_KEY else 1]
        with self._there:
            self._waiting.pop(kind, None)
            self._waiting[kind] = message
            self._there.notify()

    def _run(self) -> None:
        try:
            while True:
                message = self._next()
                self._connection.send(message)
                if message[0] == CLOSE:
                    return
        except OSError:
            return  # the race has ended; the receiving thread will notice

    def _next(self) -> Message:
        with self._there:
            while not self._waiting:
                self._there.wait()
            return self._waiting.pop(next(iter(self._waiting)))
