"""Reserves a ROS_DOMAIN_ID on this machine among firstlap processes."""

from __future__ import annotations

import fcntl
import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from firstlap.common.errors import InputError

DOMAINS = range(1, 102)
"""Domain IDs that are safe on all platforms (docs.ros.org, About-Domain-ID), without 0, which the car's nodes use."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Yields an unused domain. Raises InputError if all are in use."""
    for domain in random.SystemRandom().sample(DOMAINS, len(DOMAINS)):
        path = Path(tempfile.gettempdir()) / f"firstlap-domain-{domain}.lock"
        if not path.exists():
            path.touch()
        with path.open() as lock:  # opened for reading: the file may belong to another user
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
