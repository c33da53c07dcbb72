"""MCAP files, read from front to end: that works for finished, unfinished and damaged ones alike."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mcap import records
from mcap.stream_reader import StreamReader

from firstlap.recordings.messages import Message, Stored, Topic, said

ENCODINGS = {"cdr": "cdr", "ros1": "ros1"}


def open_mcap(path: Path) -> Stored:
    """What the file holds; nothing is read before `messages`."""
    stored = Stored()
    stored.messages = lambda: _messages(path, stored)
    return stored


def _messages(path: Path, stored: Stored) -> Iterator[Message]:
    schemas: dict[int, str] = {}
    channels: dict[int, str] = {}
    finished = False
    try:
        with path.open("rb") as file:
            for record in StreamReader(file, record_size_limit=max(path.stat().st_size, 1)).records:
                if isinstance(record, records.Message):
                    if record.channel_id in channels:
                        yield Message(channels[record.channel_id], record.log_time, record.data)
                elif isinstance(record, records.Schema):
                    schemas[record.id] = record.name
                elif isinstance(record, records.Channel):
                    _add_channel(record, schemas, channels, stored)
                elif isinstance(record, records.Metadata):
                    stored.metadata[record.name] = dict(record.metadata)
                elif isinstance(record, records.Statistics):
                    _note_counts(record, channels, stored)
                elif isinstance(record, records.Footer):
                    finished = True
    except Exception as error:  # a damaged file may make the library raise anything
        if not finished:
            stored.remarks.append(
                f"{path.name} is unfinished, cut off or damaged; what stands before that was read ({said(error)})"
            )


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
