"""Arbitration between driving nodes on one drive topic: they exchange claims, and one of them yields. No ROS imports.

A node that drives has precedence; among equals, the one that started first.
"""

from __future__ import annotations

import json
from typing import NamedTuple

HEARTBEAT = 0.5
"""[s] Period of a node's claims."""
LASTS = 3.0
"""[s] Lifetime of a claim, for nodes that died."""
SETTLE = 3.0
"""[s] After its start, a node only looks for others for this time."""
MAX_TEXT = 1000


class Claim(NamedTuple):
    """born: start time [ns], wall clock. who: display name of the node. drives: whether it may move the car."""

    born: int
    who: str
    drives: bool

    def encode(self) -> str:
        """The text that is published."""
        return json.dumps(self._asdict())


def decode(text: str) -> Claim:
    """Parses a claim. Raises ValueError."""
    if len(text) > MAX_TEXT:
        raise ValueError(f"a claim of {len(text)} characters")
    found = json.loads(text)
    if not isinstance(found, dict) or set(found) != set(Claim._fields):
        raise ValueError(f"not a claim: {text[:80]}")
    born, who, drives = (found[name] for name in Claim._fields)
    if type(born) is not int or type(who) is not str or type(drives) is not bool:
        raise ValueError(f"not a claim: {text[:80]}")
    return Claim(born, who, drives)


class Claims:
    """The claims of other nodes on the topic. born, who: of this node."""

    def __init__(self, born: int, who: str) -> None:
        self._own = (born, who)
        self._others: dict[tuple[int, str], tuple[Claim, float]] = {}

    def own(self, drives: bool) -> Claim:
        """This node's claim."""
        return Claim(*self._own, drives)

    def add(self, text: str, now: float) -> None:
        """Adds a claim received at `now` [s], possibly this node's own. Raises ValueError."""
        claim = decode(text)
        self._others = {key: one for key, one in self._others.items() if now - one[1] <= LASTS}
        if claim[:2] != self._own:
            self._others[claim[:2]] = (claim, now)

    def reason(self, drives: bool, now: float) -> str:
        """Why this node must not drive; empty if it may. drives: whether it drives already."""
        for key, (claim, heard) in self._others.items():
            older = key < self._own
            if now - heard <= LASTS and ((claim.drives and older) if drives else (claim.drives or older)):
                state = "drives" if claim.drives else "started first"
                return f"another driving node {state}: {claim.who}; stop one of them"
        return ""
