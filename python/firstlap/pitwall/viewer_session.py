"""What the controls of one viewer share: how work is done for a click, and how a refusal is shown."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import Any

import viser

from firstlap.common.errors import InputError

STAYS = 8.0
"""[s] that a notice is shown."""


def assign(handle: Any, name: str, value: object) -> None:
    """An attribute of a control, without a message where nothing changes."""
    if getattr(handle, name) != value:
        setattr(handle, name, value)


class ViewerSession:
    """Of one viewer. lock: held while its controls are changed."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self.client = client
        self.gui = client.gui
        self.lock = threading.RLock()

    def refuse(self, what: str, why: str) -> None:
        """A red notice."""
        self.client.add_notification(what, why, color="red", auto_close_seconds=STAYS)

    def tell(self, what: str, more: str) -> None:
        """A green notice."""
        self.client.add_notification(what, more, color="green", auto_close_seconds=STAYS)

    def attempt(self, what: str, work: Callable[[], object]) -> bool:
        """Whether it was done; what went wrong is shown, and where it is our mistake also printed."""
        try:
            work()
        except InputError as error:
            self.refuse(f"{what}: refused", str(error))
        except Exception as error:
            self.blame(what, error)
        else:
            return True
        return False

    def blame(self, what: str, error: Exception) -> None:
        """A mistake of ours."""
        text = " ".join(str(error).split())[:200]
        print(f"view: {what}: {type(error).__name__}: {text}", file=sys.stderr)
        self.refuse(f"{what}: failed", f"{type(error).__name__}: {text}")

    def click(self, what: str, work: Callable[[], object]) -> Callable[[Any], None]:
        """A callback for a button or a command."""

        def clicked(_event: Any) -> None:
            self.attempt(what, work)

        return clicked

    def choice(self, what: str, work: Callable[[Any], object], back: Callable[[], object]) -> Callable[[Any], None]:
        """A callback for an input, with its value; `back` shows what is in force where it was refused."""

        def chosen(event: Any) -> None:
            if event.client_id is not None and not self.attempt(what, lambda: work(event.target.value)):
                back()

        return chosen
