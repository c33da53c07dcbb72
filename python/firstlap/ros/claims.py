"""Who drives on a drive topic: driving nodes tell each other, and one of them gives way. Plain Python: no ROS.

The node that drives has precedence; among equals, the one that was born first.
"""

from __future__ import annotations

import json
from typing import NamedTuple

HEARTBEAT = 0.5
"""[s] between two claims of a node."""
LASTS = 3.0
"""[s] that a claim counts: a node that died says no more."""
SETTLE = 3.0
"""[s] of its life in which a node only looks for others."""
MAX_TEXT = 1000


class Claim(NamedTuple):
    """born: [ns] of the wall clock. who: a name for people. drives: whether the car may move by it."""

    born: int
    who: str
    drives: bool

    def encode(self) -> str:
        """As it is published."""
        return json.dumps(self._asdict())


def decode(text: str) -> Claim:
    """Raises ValueError where it is no claim."""
    if len(text) > MAX_TEXT:
        raise ValueError(f"a claim of {len(text)} characters")
    found = json.loads(text)
    if not isinstance(found, dict) or set(found) != set(Claim._fields):
        raise ValueError(f"no claim: {text[:80]}")
    born, who, drives = (found[name] for name in Claim._fields)
    if type(born) is not int or type(who) is not str or type(drives) is not bool:
        raise ValueError(f"no claim: {text[:80]}")
    return Claim(born, who, drives)


class Claims:
    """What the others on the topic claim. born, who: of ourselves."""

    def __init__(self, born: int, who: str) -> None:
        self._own = (born, who)
        self._others: dict[tuple[int, str], tuple[Claim, float]] = {}

    def own(self, drives: bool) -> Claim:
        """What we claim."""
        return Claim(*self._own, drives)

    def hear(self, text: str, now: float) -> None:
        """A claim came at `now` [s], perhaps our own. Raises ValueError where it is none."""
        claim = decode(text)
        self._others = {key: one for key, one in self._others.items() if now - one[1] <= LASTS}
        if claim[:2] != self._own:
            self._others[claim[:2]] = (claim, now)

    def reason(self, drives: bool, now: float) -> str:
        """Why we must not drive; empty where we may. drives: whether we do already."""
        for key, (claim, heard) in self._others.items():
            older = key < self._own
            if now - heard <= LASTS and ((claim.drives and older) if drives else (claim.drives or older)):
                does = "drives" if claim.drives else "was there first"
                return f"another driving node {does}: {claim.who}; end one of them"
        return ""
