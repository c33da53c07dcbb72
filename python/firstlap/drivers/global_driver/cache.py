"""The cache of maps and lines in the user's cache folder, with hashes of their inputs as keys."""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from firstlap.common.cache import cache_folder, hash_of_code
from firstlap.common.errors import InputError
from firstlap.common.version import __version__

FACTS = "facts.json"
SOURCES = (
    "mapping",
    "planning/raceline",
    "tracks",
    "drivers/mapping_drive.py",
    "drivers/global_driver/prepare.py",
    "drivers/global_driver/drivable_area.py",
    "control/mpc/model.py",
)
"""What of the package's Python a map or a line is made by."""


def key_of(said: dict[str, Any]) -> str:
    """Hash of the inputs, this version and the code."""
    whole = {"version": __version__, "code": _code(), **said}
    return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:40]


@cache
def _code() -> str:
    return hash_of_code(SOURCES)


def stored(key: str, make: Callable[[Path], dict[str, Any]]) -> tuple[Path, dict[str, Any], bool]:
    """The folder of a key, its facts, and whether it existed; otherwise `make` fills a new one.

    A folder is renamed when it is complete, so an incomplete one is never found. Raises InputError.
    """
    place = cache_folder("global") / key
    facts = _facts(place)
    if facts is not None:
        return place, facts, True
    temporary = _new_folder(place.parent)
    try:
        facts = make(temporary)
        _finish(temporary, place, facts)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return place, facts, False


def _facts(place: Path) -> dict[str, Any] | None:
    try:
        found = json.loads((place / FACTS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def _new_folder(parent: Path) -> Path:
    try:
        parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=".", dir=parent))
    except OSError as error:
        raise InputError(f"{parent}: cannot create the folder for maps and lines ({error.strerror})") from None


def _finish(temporary: Path, place: Path, facts: dict[str, Any]) -> None:
    try:
        (temporary / FACTS).write_text(json.dumps(facts), encoding="utf-8")
        if place.exists() and _facts(place) is None:
            shutil.rmtree(place)
        temporary.replace(place)
    except OSError as error:
        if _facts(place) is None:  # otherwise another process was faster
            raise InputError(f"{place}: cannot be written ({error.strerror})") from None
