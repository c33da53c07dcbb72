"""The user's cache folder, and the code hash that identifies which version made its contents."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from firstlap import _core

PACKAGE = Path(__file__).resolve().parents[1]


def cache_folder(name: str) -> Path:
    """$FIRSTLAP_CACHE/name, or firstlap/name in the user's cache folder."""
    if os.environ.get("FIRSTLAP_CACHE"):
        return Path(os.environ["FIRSTLAP_CACHE"]) / name
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "firstlap" / name


@cache
def code_hash(with_python: bool) -> str:
    """Hash of the compiled core; with_python: also of the package's Python sources."""
    return hash_of_code(["."] if with_python else [])


def hash_of_code(sources: Iterable[str]) -> str:
    """Hash of the compiled core and of `sources`: files and folders of this package. Raises OSError."""
    digest = hashlib.sha256(Path(_core.__file__).read_bytes())
    for name in sources:
        place = PACKAGE / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
