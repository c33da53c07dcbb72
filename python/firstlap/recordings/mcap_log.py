"""Reads MCAP files sequentially, which also works for unfinished and damaged files."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.writer import MCAP0_MAGIC

from firstlap.recordings.messages import Message, Stored, Topic, check_magic, stopped

ENCODINGS = {"cdr": "cdr", "ros1": "ros1"}
RECORD_HEAD = struct.Struct("<BQ")
"""Opcode and length of a record."""
MESSAGE_HEAD = struct.Struct("<HIQQ")
"""Channel, number, time of logging and of publishing of a message."""
CHUNK_HEAD = struct.Struct("<QQQII")
"""Two times, size, checksum and the length of the compression's name."""
PACKED_LENGTH = struct.Struct("<Q")
"""After that name: length of the packed records."""
RECORDS = frozenset(int(opcode) for opcode in Opcode)
FIRST_PRIVATE = 0x80
"""Opcodes from here on are private."""
KEPT: dict[int, Any] = {
    Opcode.SCHEMA: records.Schema,
    Opcode.CHANNEL: records.Channel,
    Opcode.METADATA: records.Metadata,
    Opcode.STATISTICS: records.Statistics,
}
"""Records that the library parses; messages are too many, and indexes are not needed."""


def open_mcap(path: Path) -> Stored:
    """Opens the file; only its first bytes are read before `messages`. Raises InputError."""
    check_magic(path, MCAP0_MAGIC, "an MCAP file")
    stored = Stored()
    stored.messages = lambda: _messages(path, stored)
    return stored


class _LostError(Exception):
    """There is no record here, or its length is implausible."""


def _messages(path: Path, stored: Stored) -> Iterator[Message]:
    """Yields messages; continues after damage at the next record, or at the next chunk in the file's index."""
    content, size, read, bad = _Content(stored), path.stat().st_size, 0, 0
    with path.open("rb") as file:
        file.seek(len(MCAP0_MAGIC))
        while True:
            try:
                opcode, length, data = _record(file, size, content)
                if opcode == Opcode.FOOTER:
                    break
                for message in content.take(opcode, data, len(data) == length):
                    yield message
                    read += 1
                if len(data) < length:
                    raise _LostError
            except OSError:
                raise
            except Exception as error:  # the libraries may raise any exception for a damaged file
                content.learn(file, size)
                following = content.next_chunk()
                if isinstance(error, _LostError) and following is None:
                    stored.remarks.append(stopped(path, read, "unfinished, cut off or damaged"))
                    break
                bad += 1
                if isinstance(error, _LostError) and following is not None:
                    content.chunk_at = following
                    file.seek(following)
    if bad:
        stored.remarks.append(f"{path.name} is damaged: {bad} parts were skipped, {read} messages were read")
    if content.unknown:
        stored.remarks.append(f"{path.name} is damaged: the topics of {content.unknown} messages are unknown")


def _record(file: BinaryIO, size: int, content: _Content) -> tuple[int, int, bytes]:
    """Opcode, length and bytes of the next record; fewer bytes if the file ends, none if the record is not needed."""
    begin = file.tell()
    head = file.read(RECORD_HEAD.size)
    if len(head) < RECORD_HEAD.size:
        raise _LostError
    opcode, length = RECORD_HEAD.unpack(head)
    rest = size - file.tell()
    ends = rest == length + len(MCAP0_MAGIC)
    if (opcode not in RECORDS and opcode < FIRST_PRIVATE) or (opcode == Opcode.FOOTER and not ends):
        raise _LostError
    if opcode == Opcode.CHUNK:
        content.chunk_at = begin
    if opcode in KEPT or opcode in (Opcode.CHUNK, Opcode.MESSAGE):
        return opcode, length, file.read(min(length, rest))
    if length > rest:
        raise _LostError
    file.seek(length, os.SEEK_CUR)
    return opcode, 0, b""


class _Content:
    """Schemas and channels read so far, by their ids.

    chunk_at: offset of the last chunk. unknown: number of messages of unknown channels.
    """

    def __init__(self, stored: Stored) -> None:
        self.stored = stored
        self.schemas: dict[int, str] = {}
        self.channels: dict[int, str] = {}
        self.explained: set[int] = set()
        self.chunk_at = 0
        self.unknown = 0
        self._chunks: list[int] | None = None

    def take(self, opcode: int, data: bytes, whole: bool = True) -> Iterator[Message]:
        """The messages in a record; schemas and channels are stored. May raise any exception for damaged records."""
        if opcode == Opcode.MESSAGE:
            channel, _, time, _ = MESSAGE_HEAD.unpack_from(data)
            if channel in self.channels and whole:
                yield Message(self.channels[channel], time, data[MESSAGE_HEAD.size :])
            self.unknown += channel not in self.explained
        elif opcode == Opcode.CHUNK:
            yield from self.records_in(_unpacked(data, whole), whole)
        elif opcode in KEPT and whole:
            self.keep(KEPT[opcode].read(ReadDataStream(BytesIO(data))))

    def learn(self, file: BinaryIO, size: int) -> None:
        """Reads schemas and channels from the summary at the file's end, once, in case a damaged chunk had them."""
        if self._chunks is not None:
            return
        self._chunks, here = [], file.tell()
        file.seek(0)
        try:
            summary = SeekingReader(file, record_size_limit=size).get_summary()
        except OSError:
            raise
        except Exception:  # the summary is also damaged, or missing
            summary = None
        file.seek(here)
        if summary is None:
            return
        self._chunks = sorted(chunk.chunk_start_offset for chunk in summary.chunk_indexes)
        for key, schema in summary.schemas.items():
            self.schemas.setdefault(key, schema.name)
        for key, channel in summary.channels.items():
            if key not in self.explained:
                self.keep(channel)

    def next_chunk(self) -> int | None:
        """Offset of the chunk after the last one, from the file's index."""
        return next((begin for begin in self._chunks or () if begin > self.chunk_at), None)

    def keep(self, record: Any) -> None:
        """Stores schemas, channels, metadata and counts."""
        if isinstance(record, records.Schema):
            self.schemas[record.id] = record.name
        elif isinstance(record, records.Channel):
            self.explained.add(record.id)
            _add_channel(record, self.schemas, self.channels, self.stored)
        elif isinstance(record, records.Metadata):
            self.stored.metadata[record.name] = dict(record.metadata)
        elif isinstance(record, records.Statistics):
            _note_counts(record, self.channels, self.stored)

    def records_in(self, data: bytes, whole: bool) -> Iterator[Message]:
        """The messages of a complete or partial chunk."""
        begin = RECORD_HEAD.size
        while begin <= len(data):
            opcode, length = RECORD_HEAD.unpack_from(data, begin - RECORD_HEAD.size)
            end = begin + length
            if end > len(data) and whole:
                raise ValueError("a record is longer than its chunk")
            if end > len(data):
                return
            yield from self.take(opcode, data[begin:end])
            begin = end + RECORD_HEAD.size


def _unpacked(chunk: bytes, whole: bool) -> bytes:
    """The records in a chunk, as many as there are in a partial one. The checksum of a complete one is verified."""
    _, _, size, checksum, length = CHUNK_HEAD.unpack_from(chunk)
    begin = CHUNK_HEAD.size + length
    compression, data = chunk[CHUNK_HEAD.size : begin].decode(), chunk[begin + PACKED_LENGTH.size :]
    (packed,) = PACKED_LENGTH.unpack_from(chunk, begin)
    if whole and packed != len(data):
        raise _LostError
    complete = packed <= len(data)
    data = _decompressed(compression, data[:packed])
    if complete and (len(data) != size or (checksum and zlib.crc32(data) != checksum)):
        raise ValueError("not what was written")
    return data


def _decompressed(compression: str, data: bytes) -> bytes:
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompressobj().decompress(data)
    if compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data))
    if compression:
        raise ValueError("a chunk packed by what is not known")
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
