"""Reads rosbag2: folders of sqlite3 or MCAP files with metadata.yaml, single .db3 files, and compressed files."""

from __future__ import annotations

import sqlite3
import struct
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path, PurePath
from typing import Any

import yaml
import zstandard

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import LOADER, MAX_YAML_BYTES
from firstlap.recordings.mcap_log import open_mcap
from firstlap.recordings.messages import ZSTD_MAGIC, Message, Stored, Topic, check_magic, stopped
from firstlap.recordings.paths import COMPRESSED, STORAGES, ending_of

SQLITE_MAGIC = b"SQLite format 3\0"
SQLITE_PAGES = struct.Struct(">16xH10xI")
"""Page size in bytes (1 means 65536) and number of pages in the database header."""


def open_db3(path: Path) -> Stored:
    """Opens one sqlite3 file; only its first bytes are read before `messages`. Raises InputError."""
    check_magic(path, SQLITE_MAGIC, "an SQLite database")
    stored = Stored()
    stored.messages = lambda: _rows(path, stored)
    return stored


def _rows(path: Path, stored: Stored) -> Iterator[Message]:
    # Without a write-ahead log no process is writing, and no lock or file is needed.
    writing = path.with_name(path.name + "-wal").exists()
    address = f"{path.resolve().as_uri()}?mode=ro{'' if writing else '&immutable=1'}"
    read = odd = 0
    try:
        with closing(sqlite3.connect(address, uri=True, check_same_thread=False)) as database:
            database.execute("PRAGMA writable_schema=ON")  # otherwise sqlite refuses a truncated file
            names: dict[int, str] = {}
            topics = database.execute("SELECT id, name, type, serialization_format FROM topics")
            for key, name, kind, encoding in topics:
                names[key] = str(name)
                if encoding == "cdr":
                    stored.topics[str(name)] = Topic(str(name), str(kind))
            for key, time, data in database.execute("SELECT topic_id, timestamp, data FROM messages"):
                if key not in names or not isinstance(time, int) or not isinstance(data, bytes):
                    odd += 1
                elif names[key] in stored.topics:
                    yield Message(names[key], time, data)
                    read += 1
    except (sqlite3.Error, UnicodeDecodeError):
        stored.remarks.append(stopped(path, read))
    else:
        if not writing and _is_short(path):
            stored.remarks.append(stopped(path, read, "cut off"))
    if odd:
        stored.remarks.append(f"{path.name} is damaged: {odd} messages without topic, time or bytes")


def _is_short(path: Path) -> bool:
    """Whether the file is shorter than stated in its header."""
    with path.open("rb") as file:
        head = file.read(SQLITE_PAGES.size)
    if len(head) < SQLITE_PAGES.size:
        return True
    page, pages = SQLITE_PAGES.unpack(head)
    return path.stat().st_size < (65536 if page == 1 else page) * pages


def open_folder(path: Path) -> Stored:
    """Opens a rosbag2 folder. Raises InputError if it contains no recording.

    Without a readable metadata.yaml, the files in the folder are read.
    """
    stored = Stored()
    about = _metadata(path, stored)
    files = _files(path, about, stored)
    packed = str(about.get("compression_mode") or "").lower()
    if packed not in ("", "none") and str(about.get("compression_format")) != "zstd":
        raise InputError(f"{path}: compressed with '{about.get('compression_format')}'; expected zstd")
    stored.claimed = _claimed(about)
    stored.messages = lambda: _messages(files, stored)
    return stored


def open_packed(path: Path) -> Stored:
    """Opens one compressed file of a rosbag2. Raises InputError."""
    check_magic(path, ZSTD_MAGIC, "compressed by zstd")
    stored = Stored()
    stored.messages = lambda: _messages([path], stored)
    return stored


def _metadata(path: Path, stored: Stored) -> dict[str, Any]:
    file = path / "metadata.yaml"
    if not file.is_file():
        stored.remarks.append("no metadata.yaml; the files in the folder were read")
        return {}
    try:
        if file.stat().st_size > MAX_YAML_BYTES:
            raise ValueError("larger than any bag's metadata")
        about = yaml.load(file.read_text(encoding="utf-8"), Loader=LOADER)["rosbag2_bagfile_information"]
        if not isinstance(about, dict):
            raise TypeError("no mapping")
        return about
    except OSError:
        raise
    except Exception:  # PyYAML's constructors may raise any exception for an invalid tag
        stored.remarks.append("metadata.yaml is invalid; the files in the folder were read")
        return {}


def _claimed(about: dict[str, Any]) -> dict[str, int]:
    """The number of messages per topic in the metadata; invalid entries are ignored."""
    claimed = {}
    topics = about.get("topics_with_message_count")
    for topic in topics if isinstance(topics, list) else ():
        named = topic.get("topic_metadata") if isinstance(topic, dict) else None
        count = topic.get("message_count") if isinstance(topic, dict) else None
        if isinstance(named, dict) and isinstance(count, int):
            claimed[str(named.get("name"))] = count
    return claimed


def _files(path: Path, about: dict[str, Any], stored: Stored) -> list[Path]:
    """The files in order."""
    storage = str(about.get("storage_identifier") or "")  # a reindex may leave it empty
    if storage and storage not in STORAGES:
        raise InputError(f"{path}: unknown storage '{storage[:60]}'; expected {', '.join(STORAGES)}")
    suffixes = [STORAGES[storage]] if storage else list(STORAGES.values())
    lying = sorted(file for file in path.iterdir() if file.is_file() and _suffix(file) in suffixes)
    listed = about.get("relative_file_paths")
    named = [path / PurePath(str(name)).name for name in listed] if isinstance(listed, list) else []
    missing = [file.name for file in named if not file.is_file()]
    if missing:
        stored.remarks.append(f"metadata.yaml names {', '.join(missing)[:200]}, which does not exist")
    files = [file for file in named if file.is_file()] or lying
    if not files:
        raise InputError(f"{path}: the folder contains no recording; {_instead(path, suffixes)}")
    return files


def _instead(path: Path, suffixes: list[str]) -> str:
    """The hint for a folder that is not a rosbag2 but may contain other recordings."""
    other = sorted(file.name for file in path.iterdir() if file.is_file() and ending_of(file))
    return f"give a file in it, such as {other[0]}" if other else f"expected {' or '.join(suffixes)} files in it"


def _suffix(file: Path) -> str:
    """The suffix of the storage, without that of the compression."""
    return PurePath(file.stem).suffix.lower() if file.suffix.lower() in COMPRESSED else file.suffix.lower()


def _messages(files: list[Path], stored: Stored) -> Iterator[Message]:
    claimed = dict(stored.claimed)
    for file in files:
        with tempfile.TemporaryDirectory() as folder:
            opener = open_mcap if _suffix(file) == STORAGES["mcap"] else open_db3
            try:
                part = opener(_unpacked(file, Path(folder)))
            except (zstandard.ZstdError, OSError):
                stored.remarks.append(f"{file.name} cannot be decompressed: truncated or damaged")
                continue
            except InputError as error:
                stored.remarks.append(f"{str(error).rpartition('/')[2]}; it was skipped")
                continue
            part.topics, part.remarks, part.metadata = stored.topics, stored.remarks, stored.metadata
            part.wanted = stored.wanted
            yield from part.messages()
            for topic, count in part.claimed.items():
                claimed.setdefault(topic, 0)
                if topic not in stored.claimed:
                    claimed[topic] += count
    stored.claimed = claimed


def _unpacked(file: Path, folder: Path) -> Path:
    if file.suffix.lower() not in COMPRESSED:
        return file
    whole = folder / file.stem
    with file.open("rb") as packed, whole.open("wb") as out:
        if zstandard.ZstdDecompressor().copy_stream(packed, out)[1] == 0:
            raise zstandard.ZstdError("not even the first frame is whole")
    return whole
