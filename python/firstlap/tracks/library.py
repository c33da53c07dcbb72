"""Loads any track by name: ours, a file, a ROS map or a random one.

The modules that read and make tracks are imported when needed: a process that receives a track needs none of them.
"""

from __future__ import annotations

import difflib
from pathlib import Path

from firstlap.common.data_folder import data_folder
from firstlap.common.errors import InputError
from firstlap.common.yaml_text import parse_mapping, read_text
from firstlap.tracks.track import Track

CENTERLINES = (".csv",)
TRACK_FILES = (".yaml", ".yml", *CENTERLINES)
"""Suffixes of track files, ROS maps and centerlines."""


def tracks_folder() -> Path:
    """The folder of our own tracks, in the installed package or in the source checkout."""
    return data_folder("tracks")


def list_tracks() -> list[str]:
    """Names of our own tracks, sorted."""
    return sorted(path.stem for path in tracks_folder().glob("*.yaml"))


def load_track(spec: str) -> Track:
    """The track named by `spec`: one of ours, `random:SEED`, or the path of a track file, ROS map or centerline.

    Raises InputError if there is no such track or its file is invalid.
    """
    if spec.startswith("random:"):
        from firstlap.tracks.random_track import random_track

        return random_track(_seed(spec))
    if spec in list_tracks():
        from firstlap.tracks.track_file import load_track_file

        return load_track_file(tracks_folder() / f"{spec}.yaml")
    path = Path(spec)
    try:
        if path.exists():
            return _load_file(path)
    except (OSError, ValueError):
        pass
    near = difflib.get_close_matches(spec, list_tracks(), n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"available: {', '.join(list_tracks())}"
    raise InputError(f"{spec[:200]!r}: no such track or file; {hint}")


def _load_file(path: Path) -> Track:
    from firstlap.tracks.centerline_file import load_centerline
    from firstlap.tracks.ros_map import load_ros_map
    from firstlap.tracks.track_file import load_track_file

    if path.suffix.lower() in CENTERLINES:
        return load_centerline(path)
    data = parse_mapping(read_text(path), str(path))
    return load_ros_map(path) if "image" in data else load_track_file(path)


def _seed(spec: str) -> int:
    digits = spec.removeprefix("random:")
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 18):
        raise InputError(f"{spec[:60]!r}: expected random:SEED with an integer from 0, for example random:7")
    return int(digits)
