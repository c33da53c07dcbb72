"""Raw messages of a recording: the interface of all storages, and decoding."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import zstandard
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from firstlap.common.errors import InputError

ACKERMANN = "ackermann_msgs/msg/AckermannDrive"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""First bytes of a message compressed individually by rosbag2. CDR begins with 0, so there is no ambiguity."""
_ACKERMANN_TEXT = """float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
"""
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""The second definition is that of old ROS 1."""
_TRANSFORMS_TEXT = "geometry_msgs/TransformStamped[] transforms"
_STAMPED_TEXT = """std_msgs/Header header
ackermann_msgs/AckermannDrive drive
"""


class Message(NamedTuple):
    """A stored message: topic, log time [ns], bytes."""

    topic: str
    time: int
    data: bytes


@dataclass(frozen=True)
class Topic:
    """type is a ROS 2 name such as sensor_msgs/msg/LaserScan; encoding is cdr or ros1."""

    name: str
    type: str
    encoding: str = "cdr"


@dataclass
class Stored:
    """The content of a storage. `messages` never raises for damage: it ends and adds a remark.

    topics may grow while messages are read. claimed: number of messages per topic by the metadata.
    wanted: required types; messages of other types may be omitted.
    """

    topics: dict[str, Topic] = field(default_factory=dict)
    messages: Callable[[], Iterator[Message]] = lambda: iter(())
    remarks: list[str] = field(default_factory=list)
    claimed: dict[str, int] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    wanted: frozenset[str] | None = None


@lru_cache(maxsize=2)
def typestore(encoding: str = "cdr") -> Typestore:
    """The message types that we read and write, including those missing in the library."""
    store = get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(_ACKERMANN_TEXT, ACKERMANN))
    store.register(get_types_from_msg(_STAMPED_TEXT, f"{ACKERMANN}Stamped"))
    for name in TRANSFORMS:
        if name not in store.types:
            store.register(get_types_from_msg(_TRANSFORMS_TEXT, name))
    return store


def decode(topic: Topic, data: bytes) -> Any:
    """The message, decompressed if it was compressed individually; None if the bytes are not a message."""
    store = typestore(topic.encoding)
    try:
        if topic.encoding == "ros1":
            return store.deserialize_ros1(data, topic.type)
        if data.startswith(ZSTD_MAGIC):
            data = zstandard.ZstdDecompressor().decompressobj().decompress(data)
        return store.deserialize_cdr(data, topic.type)
    except Exception:  # the library may raise any exception for invalid bytes
        return None


def check_magic(path: Path, magic: bytes, what: str) -> None:
    """Raises InputError if the file does not begin with the magic bytes of `what`; a shorter file is truncated."""
    with path.open("rb") as file:
        first = file.read(len(magic))
    if not first or first != magic[: len(first)]:
        raise InputError(f"{path}: not {what}")


def stopped(path: Path, read: int, how: str = "cut off or damaged") -> str:
    """The remark for a file that could not be read to its end."""
    return f"{path.name} is {how} after {read} messages; the messages before that were read"
