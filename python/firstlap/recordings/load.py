"""Loads recordings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from firstlap.common.errors import InputError
from firstlap.recordings.paths import KINDS, PACKED, ending_of
from firstlap.recordings.recording import Recording
from firstlap.recordings.topics import Topics


def load_recording(
    path: str | Path, topics: Topics | None = None, on_progress: Callable[[int], object] | None = None
) -> Recording:
    """The recording at `path`: a file with one of `paths.ENDINGS`, or a rosbag2 folder.

    topics: topic names, if types alone are ambiguous, and other settings by the user. on_progress: called with the
    number of messages read so far. Damaged parts are skipped and reported as remarks. Raises InputError if no scan can
    be read.
    """
    path, topics = Path(path), topics or Topics()
    try:
        if not path.exists():
            raise InputError(f"{path}: no such file or folder; a recording is {KINDS}")
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{path}: is empty")
        if path.is_file() and ending_of(path) == ".npz":
            from firstlap.recordings.npz import load_npz

            return load_npz(path, topics)
        return _from_messages(path, topics, on_progress)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None


def load_libraries() -> None:
    """Imports the libraries for reading, so that their import does not count as reading time."""
    from firstlap.recordings import assemble, mcap_log, npz, ros1_bag, rosbag2
    from firstlap.recordings.messages import typestore

    del assemble, mcap_log, npz, ros1_bag, rosbag2
    typestore()


def _from_messages(path: Path, topics: Topics, on_progress: Callable[[int], object] | None) -> Recording:
    from firstlap.recordings.assemble import assemble
    from firstlap.recordings.mcap_log import open_mcap
    from firstlap.recordings.ros1_bag import open_bag
    from firstlap.recordings.rosbag2 import open_db3, open_folder, open_packed

    openers = {
        ".mcap": open_mcap,
        ".db3": open_db3,
        ".bag": open_bag,
        ".bag.active": open_bag,
        **dict.fromkeys(PACKED, open_packed),
    }
    opener = open_folder if path.is_dir() else openers.get(ending_of(path))
    if opener is None:
        raise InputError(f"{path}: not a known kind of recording; expected {KINDS}")
    return assemble(opener(path), path, topics, on_progress)
