"""The result of a command line, for the tests."""

from __future__ import annotations

import json
from typing import Any, NamedTuple


class CommandResult(NamedTuple):
    """The result of a command line."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output as one JSON value."""
        return json.loads(self.out)
