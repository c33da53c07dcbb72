"""What the race is told, sent by a thread of its own, so that nobody waits for a race that does not listen."""

from __future__ import annotations

import threading
from multiprocessing.connection import Connection
from typing import Any

CLOSE = "close"
OF_ONE_KEY = ("condition",)
"""Kinds of messages whose next word says what they are about."""

Message = tuple[Any, ...]


class Mailbox:
    """Of each kind only the newest message waits, in the order of their coming: a race that stands while a slider is
    moved is told where the slider is, not where it was, and memory stays bounded."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._waiting: dict[Message, Message] = {}
        self._there = threading.Condition()
        threading.Thread(target=self._run, name="mailbox", daemon=True).start()

    def put(self, message: Message) -> None:
        """Never waits for the race; to one that is gone: nothing. After ("close",) nothing more is sent."""
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
            return  # the race is gone, which whoever hears it will find

    def _next(self) -> Message:
        with self._there:
            while not self._waiting:
                self._there.wait()
            return self._waiting.pop(next(iter(self._waiting)))
