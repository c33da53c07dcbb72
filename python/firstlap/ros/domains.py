"""A ROS_DOMAIN_ID for a while, that nothing of ours on this machine uses meanwhile."""

from __future__ import annotations

import fcntl
import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from firstlap.common.errors import InputError

DOMAINS = range(1, 102)
"""Whose ports are nobody else's (docs.ros.org, About-Domain-ID); 0 is where a car's own nodes are."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Raises InputError where all are in use."""
    for domain in random.SystemRandom().sample(DOMAINS, len(DOMAINS)):
        path = Path(tempfile.gettempdir()) / f"firstlap-domain-{domain}.lock"
        if not path.exists():
            path.touch()
        with path.open() as lock:  # to read: the file may be another user's
            if _taken(lock.fileno()):
                continue
            yield domain
            return
    raise InputError(f"all {len(DOMAINS)} ROS domains are in use on this machine")


def _taken(file: int) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    return False
