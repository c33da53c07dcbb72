"""Recognizes recordings by the suffixes of their names."""

from __future__ import annotations

from pathlib import Path

STORAGES = {"sqlite3": ".db3", "mcap": ".mcap"}
"""Storages of rosbag2, with the suffixes of their files."""
COMPRESSED = (".zstd", ".zst")
PACKED = tuple(f"{storage}{packed}" for storage in STORAGES.values() for packed in COMPRESSED)
ENDINGS = (".npz", *STORAGES.values(), ".bag", ".bag.active", *PACKED)
"""Suffixes of recordings; `.active` is a ROS 1 bag whose recorder was killed."""
KINDS = f"{', '.join(ENDINGS)}, or a rosbag2 folder"


def ending_of(path: str | Path) -> str:
    """The suffix in ENDINGS that the name has, in lower case; empty if none."""
    name = Path(path).name.lower()
    return next((ending for ending in ENDINGS if name.endswith(ending)), "")


def is_recording(path: str | Path) -> bool:
    """Whether the path names a recording: a folder, or a file with one of ENDINGS."""
    return Path(path).is_dir() or bool(ending_of(path))


def name_of(path: str | Path) -> str:
    """The recording's name: the file name without its suffix."""
    path = Path(path)
    return path.name if path.is_dir() else path.name[: len(path.name) - len(ending_of(path))]
