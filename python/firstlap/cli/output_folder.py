"""The output folder of a command."""

from __future__ import annotations

from pathlib import Path

from firstlap.common.errors import InputError


def output_folder(path: Path, option: str = "--out") -> Path:
    """Creates the folder. Raises InputError, naming the option, if nothing can be written there."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"{option} {path}: cannot be written ({error.strerror})") from None
    return path
