"""What one command line came to, for the tests."""

from __future__ import annotations

import json
from typing import Any, NamedTuple


class Said(NamedTuple):
    """What one command line came to."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output as one JSON value."""
        return json.loads(self.out)
