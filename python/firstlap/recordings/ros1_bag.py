"""Reads ROS 1 bags sequentially without their index, which also works for unindexed and truncated files."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from rosbags.rosbag1.reader import Header, RecordType, decompressors, normalize, read_bytes, read_uint32
from rosbags.typesys.msg import normalize_msgtype

from firstlap.recordings.messages import Message, Stored, Topic, check_magic, stopped

MAGIC = b"#ROSBAG V2.0\n"


def open_bag(path: Path) -> Stored:
    """Opens the bag; only its first line is read before `messages`. Raises InputError."""
    check_magic(path, MAGIC, "a ROS 1 bag of version 2.0")
    stored = Stored()
    stored.messages = lambda: _messages(path, stored)
    return stored


def _messages(path: Path, stored: Stored) -> Iterator[Message]:
    connections: dict[int, str] = {}
    size, read = path.stat().st_size, 0
    try:
        with path.open("rb") as file:
            file.seek(len(MAGIC))
            while file.tell() < size:
                header = Header.read(file)
                kind = header.get_uint8("op")
                length = read_uint32(file)
                if length > size:
                    raise ValueError(f"a record of {length} bytes")
                if kind == RecordType.CHUNK:
                    chunk = decompressors[header.get_string("compression")](read_bytes(file, length))
                    messages = _chunk(BytesIO(chunk), len(chunk), connections, stored)
                elif kind in (RecordType.CONNECTION, RecordType.MSGDATA):
                    messages = _record(header, read_bytes(file, length), connections, stored)
                else:
                    read_bytes(file, length)
                    continue
                for message in messages:
                    yield message
                    read += 1
    except Exception:  # the library may raise any exception for a damaged file
        stored.remarks.append(stopped(path, read))


def _chunk(file: BinaryIO, size: int, connections: dict[int, str], stored: Stored) -> Iterator[Message]:
    while file.tell() < size:
        header = Header.read(file)
        yield from _record(header, read_bytes(file, read_uint32(file)), connections, stored)


def _record(header: Header, data: bytes, connections: dict[int, str], stored: Stored) -> Iterator[Message]:
    kind = header.get_uint8("op")
    if kind == RecordType.CONNECTION:
        topic = normalize(header.get_string("topic"))
        about = Header.read(BytesIO(len(data).to_bytes(4, "little") + data))
        connections[header.get_uint32("conn")] = topic
        stored.topics[topic] = Topic(topic, normalize_msgtype(about.get_string("type")), "ros1")
    elif kind == RecordType.MSGDATA:
        connection = header.get_uint32("conn")
        if connection in connections:
            yield Message(connections[connection], header.get_time("time"), data)
