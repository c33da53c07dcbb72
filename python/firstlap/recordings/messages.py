"""Raw messages of a recording: what every storage gives, and how they are decoded."""

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
"""With which a message begins that rosbag2 compressed by itself. CDR begins with 0, so that none is mistaken."""
_ACKERMANN_TEXT = """float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
"""
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""The second is that of old ROS 1."""
_TRANSFORMS_TEXT = "geometry_msgs/TransformStamped[] transforms"
_STAMPED_TEXT = """std_msgs/Header header
ackermann_msgs/AckermannDrive drive
"""


class Message(NamedTuple):
    """One message as it was stored: topic, nanoseconds of its logging, bytes."""

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
    """What a storage holds. `messages` reads on and never raises for damage: it ends and adds a remark.

    topics may still grow while messages are read. claimed: how many messages a topic has by the metadata.
    wanted: types of interest; messages of others need not be given.
    """

    topics: dict[str, Topic] = field(default_factory=dict)
    messages: Callable[[], Iterator[Message]] = lambda: iter(())
    remarks: list[str] = field(default_factory=list)
    claimed: dict[str, int] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    wanted: frozenset[str] | None = None


@lru_cache(maxsize=2)
def typestore(encoding: str = "cdr") -> Typestore:
    """The message types that we read and write, with those that the library lacks."""
    store = get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(_ACKERMANN_TEXT, ACKERMANN))
    store.register(get_types_from_msg(_STAMPED_TEXT, f"{ACKERMANN}Stamped"))
    for name in TRANSFORMS:
        if name not in store.types:
            store.register(get_types_from_msg(_TRANSFORMS_TEXT, name))
    return store


def decode(topic: Topic, data: bytes) -> Any:
    """The message, decompressed where it was compressed by itself, or None where the bytes are none."""
    store = typestore(topic.encoding)
    try:
        if topic.encoding == "ros1":
            return store.deserialize_ros1(data, topic.type)
        if data.startswith(ZSTD_MAGIC):
            data = zstandard.ZstdDecompressor().decompressobj().decompress(data)
        return store.deserialize_cdr(data, topic.type)
    except Exception:  # bytes that are no message make the library raise anything
        return None


def check_magic(path: Path, magic: bytes, what: str) -> None:
    """Raises InputError where the file does not begin as `what` does; a shorter one that begins so is cut off."""
    with path.open("rb") as file:
        first = file.read(len(magic))
    if not first or first != magic[: len(first)]:
        raise InputError(f"{path}: not {what}")


def stopped(path: Path, read: int, how: str = "cut off or damaged") -> str:
    """The remark where reading came to an end before the file's own."""
    return f"{path.name} is {how} after {read} messages; what stands before that was read"
