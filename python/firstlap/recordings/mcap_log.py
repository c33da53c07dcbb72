"""MCAP files, read from front to end: that works for finished, unfinished and damaged ones alike."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import zstandard
from mcap import records
from mcap.opcode import Opcode
from mcap.stream_reader import MAGIC_SIZE, StreamReader

from firstlap.recordings.messages import Message, Stored, Topic, said

ENCODINGS = {"cdr": "cdr", "ros1": "ros1"}
RECORD_HEAD = struct.Struct("<BQ")
"""Opcode and length of a record."""
CHUNK_HEAD = 28
"""Bytes of a chunk before its compression: two times, size and checksum."""


def open_mcap(path: Path) -> Stored:
    """What the file holds; nothing is read before `messages`."""
    stored = Stored()
    stored.messages = lambda: _messages(path, stored)
    return stored


class _Content:
    """What has been read so far: schemas and channels by their ids."""

    def __init__(self, stored: Stored) -> None:
        self.stored = stored
        self.schemas: dict[int, str] = {}
        self.channels: dict[int, str] = {}
        self.finished = False

    def take(self, record: Any) -> Message | None:
        """The message in `record`; anything else is kept."""
        if isinstance(record, records.Message):
            topic = self.channels.get(record.channel_id)
            return None if topic is None else Message(topic, record.log_time, record.data)
        if isinstance(record, records.Schema):
            self.schemas[record.id] = record.name
        elif isinstance(record, records.Channel):
            _add_channel(record, self.schemas, self.channels, self.stored)
        elif isinstance(record, records.Metadata):
            self.stored.metadata[record.name] = dict(record.metadata)
        elif isinstance(record, records.Statistics):
            _note_counts(record, self.channels, self.stored)
        elif isinstance(record, records.Footer):
            self.finished = True
        return None


def _messages(path: Path, stored: Stored) -> Iterator[Message]:
    content = _Content(stored)
    try:
        with path.open("rb") as file:
            reader = StreamReader(file, record_size_limit=max(path.stat().st_size, 1))
            yield from filter(None, map(content.take, reader.records))
    except Exception as error:  # a damaged file may make the library raise anything
        if content.finished:
            return
        stored.remarks.append(
            f"{path.name} is unfinished, cut off or damaged; what stands before that was read ({said(error)})"
        )
    else:
        return
    with suppress(Exception):  # the part of a record makes the library raise something in any case
        begun = StreamReader(BytesIO(_begun_chunk(path)), skip_magic=True)
        yield from filter(None, map(content.take, begun.records))


def _begun_chunk(path: Path) -> bytes:
    """What there is of the records in a chunk at whose middle the file ends; b"" where it ends elsewhere."""
    size = path.stat().st_size
    with path.open("rb") as file:
        file.seek(MAGIC_SIZE)
        while len(head := file.read(RECORD_HEAD.size)) == RECORD_HEAD.size:
            opcode, length = RECORD_HEAD.unpack(head)
            if file.tell() + length > size:
                return _records_in(file) if opcode == Opcode.CHUNK else b""
            file.seek(length, os.SEEK_CUR)
    return b""


def _records_in(file: BinaryIO) -> bytes:
    """The records in the chunk at the file's position, as far as they go."""
    file.seek(CHUNK_HEAD, os.SEEK_CUR)
    compression = file.read(int.from_bytes(file.read(4), "little")).decode()
    file.seek(8, os.SEEK_CUR)
    data = file.read()
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    return b"" if compression else data


def _add_channel(record: records.Channel, schemas: dict[int, str], channels: dict[int, str], stored: Stored) -> None:
    encoding = ENCODINGS.get(record.message_encoding)
    if encoding is None or record.id in channels:
        return
    kind = schemas.get(record.schema_id, "")
    if kind.count("/") == 1:  # a ROS 1 name
        kind = kind.replace("/", "/msg/")
    channels[record.id] = record.topic
    stored.topics[record.topic] = Topic(record.topic, kind, encoding)


def _note_counts(record: records.Statistics, channels: dict[int, str], stored: Stored) -> None:
    for channel, count in record.channel_message_counts.items():
        if channel in channels:
            topic = channels[channel]
            stored.claimed[topic] = stored.claimed.get(topic, 0) + count
