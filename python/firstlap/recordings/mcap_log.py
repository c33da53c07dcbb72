"""MCAP files, read from front to end: that works for finished, unfinished and damaged ones alike."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from firstlap.recordings.messages import Message, Stored, Topic, said

ENCODINGS = {"cdr": "cdr", "ros1": "ros1"}
RECORD_HEAD = struct.Struct("<BQ")
"""Opcode and length of a record."""
MESSAGE_HEAD = struct.Struct("<HIQQ")
"""Channel, number, time of logging and of publishing of a message."""
CHUNK_HEAD = struct.Struct("<QQQII")
"""Two times, size, checksum and the length of the compression's name."""
KEPT: dict[int, Any] = {
    Opcode.SCHEMA: records.Schema,
    Opcode.CHANNEL: records.Channel,
    Opcode.METADATA: records.Metadata,
    Opcode.STATISTICS: records.Statistics,
}
"""What the library reads for us; messages are too many, and indexes are of no use here."""


def open_mcap(path: Path) -> Stored:
    """What the file holds; nothing is read before `messages`."""
    stored = Stored()
    stored.messages = lambda: _messages(path, stored)
    return stored


def _messages(path: Path, stored: Stored) -> Iterator[Message]:
    content, size = _Content(stored), path.stat().st_size
    try:
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise ValueError("it does not begin as an MCAP file")
            while True:
                opcode, length = RECORD_HEAD.unpack(file.read(RECORD_HEAD.size))
                if opcode == Opcode.FOOTER:
                    return
                if opcode in KEPT or opcode in (Opcode.CHUNK, Opcode.MESSAGE):
                    data = file.read(min(length, size))
                    yield from content.take(opcode, data)
                    if len(data) < length:
                        raise EOFError("the file ends in the middle of a record")
                else:
                    file.seek(length, os.SEEK_CUR)
    except Exception as error:  # a damaged file may make the libraries raise anything
        stored.remarks.append(
            f"{path.name} is unfinished, cut off or damaged; what stands before that was read ({said(error)})"
        )


class _Content:
    """What has been read so far: schemas and channels by their ids."""

    def __init__(self, stored: Stored) -> None:
        self.stored = stored
        self.schemas: dict[int, str] = {}
        self.channels: dict[int, str] = {}

    def take(self, opcode: int, data: bytes) -> Iterator[Message]:
        """The messages in a record; what explains them is kept."""
        if opcode == Opcode.MESSAGE:
            channel, _, time, _ = MESSAGE_HEAD.unpack_from(data)
            if channel in self.channels:
                yield Message(self.channels[channel], time, data[MESSAGE_HEAD.size :])
        elif opcode == Opcode.CHUNK:
            yield from self.records_in(_unpacked(data))
        elif opcode in KEPT:
            self.keep(KEPT[opcode].read(ReadDataStream(BytesIO(data))))

    def keep(self, record: Any) -> None:
        """Schemas, channels, metadata and counts."""
        if isinstance(record, records.Schema):
            self.schemas[record.id] = record.name
        elif isinstance(record, records.Channel):
            _add_channel(record, self.schemas, self.channels, self.stored)
        elif isinstance(record, records.Metadata):
            self.stored.metadata[record.name] = dict(record.metadata)
        elif isinstance(record, records.Statistics):
            _note_counts(record, self.channels, self.stored)

    def records_in(self, data: bytes) -> Iterator[Message]:
        """The messages of a chunk, or of the part of one."""
        begin = RECORD_HEAD.size
        while begin <= len(data):
            opcode, length = RECORD_HEAD.unpack_from(data, begin - RECORD_HEAD.size)
            end = begin + length
            if end > len(data):
                return
            yield from self.take(opcode, data[begin:end])
            begin = end + RECORD_HEAD.size


def _unpacked(chunk: bytes) -> bytes:
    """The records in a chunk; of a part of one as many as there are."""
    *_, length = CHUNK_HEAD.unpack_from(chunk)
    begin = CHUNK_HEAD.size + length
    compression, data = chunk[CHUNK_HEAD.size : begin].decode(), chunk[begin + 8 :]
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    if compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data))
    if compression:
        raise ValueError(f"a chunk packed by {compression[:20]}")
    return data


def _add_channel(record: records.Channel, schemas: dict[int, str], channels: dict[int, str], stored: Stored) -> None:
    encoding = ENCODINGS.get(record.message_encoding)
    if encoding is None:
        return
    kind = schemas.get(record.schema_id, "")
    if kind.count("/") == 1:  # a ROS 1 name
        kind = kind.replace("/", "/msg/")
    stored.topics[record.topic] = Topic(record.topic, kind, encoding)
    if stored.wanted is None or kind in stored.wanted:
        channels[record.id] = record.topic


def _note_counts(record: records.Statistics, channels: dict[int, str], stored: Stored) -> None:
    for channel, count in record.channel_message_counts.items():
        if channel in channels:
            topic = channels[channel]
            stored.claimed[topic] = stored.claimed.get(topic, 0) + count
