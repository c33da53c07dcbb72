"""State that a driving node leaves to the next one if it dies: in a file.

The state is an emergency stop that was not released, or that the node was driving when it died. In both cases a person
must give consent before the next node drives.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

EMERGENCY = "emergency stop"
DRIVING = "driving"
LONGEST = 100
"""Maximum number of bytes read."""


class PersistentStop:
    """node: full name, such as /car1/firstlap_drive. domain: its ROS domain."""

    def __init__(self, node: str, domain: int) -> None:
        folder = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        self._path = folder / f"firstlap-{os.getuid()}-{domain}{node.replace('/', '.')}.state"

    def read(self) -> str:
        """EMERGENCY, DRIVING, or empty without a valid state of this user."""
        try:
            file = os.open(self._path, os.O_RDONLY | os.O_NOFOLLOW)
        except OSError:
            return ""
        with os.fdopen(file, "rb") as opened:
            ours = os.fstat(file).st_uid == os.getuid()
            state = opened.read(LONGEST).decode(errors="replace").strip() if ours else ""
        return state if state in (EMERGENCY, DRIVING) else ""

    def keep(self, state: str) -> None:
        """Saves the state; empty deletes it. A folder that is not writable is not an error: the state is just not
        kept."""
        with suppress(OSError):
            if not state:
                self._path.unlink(missing_ok=True)
                return
            fresh = self._path.with_suffix(f".{os.getpid()}")
            with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as opened:
                opened.write(state)
            fresh.replace(self._path)  # atomic, in case the process is killed meanwhile
