"""Checks before reading and writing, and atomic writes."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from firstlap.common.errors import InputError

LOGS = (".mcap",)


def check_readable(path: Path, expected: str) -> None:
    """Raises InputError if `path` is not a file; `expected` describes it in the message, such as 'a YAML file'."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected {expected}")
    if not path.exists():
        raise InputError(f"{path}: no such file")
    if not path.is_file():
        raise InputError(f"{path}: is a device or a pipe; expected {expected}")


def check_writable(path: str | Path, suffixes: tuple[str, ...]) -> Path:
    """Checks that a file can be written to `path`, before the work is done, and returns it. Raises InputError."""
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: expected a file name ending in {', '.join(suffixes)}")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected a file name")
    folder = path.parent
    if not folder.is_dir():
        raise InputError(f"{path}: no such folder {folder}")
    if not os.access(folder, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
        raise InputError(f"{path}: cannot be written")
    return path


def write_whole(path: Path, write: Callable[[str], None]) -> None:
    """Writes a file atomically: `write` fills a temporary file, which then replaces `path`. Raises InputError."""
    temporary = ""
    try:
        handle, temporary = tempfile.mkstemp(prefix=".", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        write(temporary)
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        Path(temporary).replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None
    finally:
        if temporary:
            Path(temporary).unlink(missing_ok=True)


def write_together(files: Mapping[Path, bytes]) -> None:
    """Writes several files that belong together: all are complete before the first one is replaced."""
    temporaries: dict[Path, Path] = {}
    try:
        for path, content in files.items():
            handle, name = tempfile.mkstemp(prefix=".", suffix=path.suffix, dir=path.parent)
            temporaries[path] = Path(name)
            with os.fdopen(handle, "wb") as file:
                file.write(content)
        mask = os.umask(0)
        os.umask(mask)
        for path, temporary in temporaries.items():
            temporary.chmod(0o666 & ~mask)
            temporary.replace(path)
    except OSError as error:
        raise InputError(f"{error.filename or next(iter(files))}: cannot be written ({error.strerror})") from None
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)
