"""Shared by the controls of one viewer: handling of clicks and notices."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import Any

import viser

from firstlap.common.errors import InputError

STAYS = 8.0
"""[s] Duration of a notice."""


def assign(handle: Any, name: str, value: object) -> None:
    """Sets an attribute of a control; sends no message if it is unchanged."""
    if getattr(handle, name) != value:
        setattr(handle, name, value)


class ViewerSession:
    """The session of one viewer. lock: held while its controls are changed."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self.client = client
        self.gui = client.gui
        self.lock = threading.RLock()

    def refuse(self, what: str, why: str) -> None:
        """Shows a red notice."""
        self.client.add_notification(what, why, color="red", auto_close_seconds=STAYS)

    def notify(self, what: str, more: str) -> None:
        """Shows a green notice."""
        self.client.add_notification(what, more, color="green", auto_close_seconds=STAYS)

    def attempt(self, what: str, work: Callable[[], object]) -> bool:
        """Calls `work` and returns whether it succeeded. Shows errors; also prints unexpected ones."""
        try:
            work()
        except InputError as error:
            self.refuse(f"{what}: refused", str(error))
        except Exception as error:
            self.report_failure(what, error)
        else:
            return True
        return False

    def report_failure(self, what: str, error: Exception) -> None:
        """Shows and prints an unexpected error."""
        text = " ".join(str(error).split())[:200]
        print(f"view: {what}: {type(error).__name__}: {text}", file=sys.stderr)
        self.refuse(f"{what}: failed", f"{type(error).__name__}: {text}")

    def click(self, what: str, work: Callable[[], object]) -> Callable[[Any], None]:
        """Makes a callback for a button or a command."""

        def clicked(_event: Any) -> None:
            self.attempt(what, work)

        return clicked

    def choice(self, what: str, work: Callable[[Any], object], back: Callable[[], object]) -> Callable[[Any], None]:
        """Makes a callback for an input, called with its value; `back` restores the display after a refusal."""

        def chosen(event: Any) -> None:
            if event.client_id is not None and not self.attempt(what, lambda: work(event.target.value)):
                back()

        return chosen
