"""Which paths are recordings: by the endings of their names, in one place."""

from __future__ import annotations

from pathlib import Path

STORAGES = {"sqlite3": ".db3", "mcap": ".mcap"}
"""Of rosbag2, with their files' endings."""
COMPRESSED = (".zstd", ".zst")
PACKED = tuple(f"{storage}{packed}" for storage in STORAGES.values() for packed in COMPRESSED)
ENDINGS = (".npz", *STORAGES.values(), ".bag", ".bag.active", *PACKED)
"""Of the files that are recordings; `.active` is a ROS 1 bag whose recorder was killed."""
KINDS = f"{', '.join(ENDINGS)}, or a rosbag2 folder"


def ending_of(path: str | Path) -> str:
    """The one of ENDINGS that the name has, in lower case; empty where it has none."""
    name = Path(path).name.lower()
    return next((ending for ending in ENDINGS if name.endswith(ending)), "")


def is_recording(path: str | Path) -> bool:
    """Whether the path names a recording: a folder, or a file with one of ENDINGS."""
    return Path(path).is_dir() or bool(ending_of(path))


def name_of(path: str | Path) -> str:
    """The recording's name: of a file without its ending."""
    path = Path(path)
    return path.name if path.is_dir() else path.name[: len(path.name) - len(ending_of(path))]
