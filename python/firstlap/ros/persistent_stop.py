"""What a driving node leaves for the one that is started after it died: a file, for nothing else outlives it.

An emergency stop that nobody released, or that it drove when it died. Where the car may not move by itself, a person
must speak first.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

EMERGENCY = "emergency stop"
DRIVING = "driving"
LONGEST = 100
"""Bytes that are read of it."""


class PersistentStop:
    """node: its full name, such as /car1/firstlap_drive. domain: the ROS domain that it is in."""

    def __init__(self, node: str, domain: int) -> None:
        folder = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        self._path = folder / f"firstlap-{os.getuid()}-{domain}{node.replace('/', '.')}.state"

    def read(self) -> str:
        """EMERGENCY, DRIVING, or empty where nothing was left, or nothing of ours."""
        try:
            file = os.open(self._path, os.O_RDONLY | os.O_NOFOLLOW)
        except OSError:
            return ""
        with os.fdopen(file, "rb") as opened:
            ours = os.fstat(file).st_uid == os.getuid()
            said = opened.read(LONGEST).decode(errors="replace").strip() if ours else ""
        return said if said in (EMERGENCY, DRIVING) else ""

    def keep(self, said: str) -> None:
        """Empty: nothing is left. A folder that cannot be written to costs the memory, never the drive."""
        with suppress(OSError):
            if not said:
                self._path.unlink(missing_ok=True)
                return
            fresh = self._path.with_suffix(f".{os.getpid()}")
            with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as opened:
                opened.write(said)
            fresh.replace(self._path)  # whoever is killed meanwhile leaves the one or the other
