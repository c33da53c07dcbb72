"""Locks for files that only one process at a time may write. The kernel releases a lock when its process ends."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from firstlap.common.errors import InputError


def lock_open_file(file: IO[Any], path: Path, busy: str, *, wait: bool = False) -> None:
    """Locks an open file until it is closed. Raises InputError with the message `busy` if another process holds it.

    wait: wait for that process instead of raising.
    """
    try:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        raise InputError(busy) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be locked ({error.strerror})") from None


@contextmanager
def locked(path: Path, key: str, busy: str, *, wait: bool = False) -> Iterator[None]:
    """Holds a temporary hidden lock file next to `path`. Raises InputError like `lock_open_file`.

    key: distinguishes several locks of one file; part of the lock's file name.
    """
    lock = path.with_name(f".{path.name}.{key}.lock")
    file = _hold(lock, path, busy, wait)
    try:
        yield
    finally:
        # Before the lock is released: a process that waits for this file sees that it was removed, and retries.
        with suppress(OSError):
            lock.unlink()
        file.close()


def _hold(lock: Path, path: Path, busy: str, wait: bool) -> IO[Any]:
    """The open and locked file; retries if the file was removed while waiting for the lock."""
    while True:
        try:
            file = lock.open("w")
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror})") from None
        try:
            lock_open_file(file, path, busy, wait=wait)
            if _is_named(file, lock):
                return file
        except BaseException:
            file.close()
            raise
        file.close()


def _is_named(file: IO[Any], path: Path) -> bool:
    try:
        there = path.stat()
    except FileNotFoundError:
        return False
    return os.path.samestat(os.fstat(file.fileno()), there)
