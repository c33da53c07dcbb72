"""Fast serialization of messages that differ only in their numbers from scan to scan.

The library serializes a message once, with marker values in place of its numbers and stamps. Their offsets are located
in the bytes, and every further message is a copy with its own numbers at these offsets.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.recordings.messages import typestore

SECONDS, NANOSECONDS = 0x5A5B5C5D, 0x0DEADBEE
"""The marker value of a stamp."""
NONE: npt.NDArray[np.float64] = np.zeros(0)
HEAD, DOUBLE = 4, 8
"""Size in bytes of the header of a CDR message, behind which alignment starts, and of a float64."""


LENGTH, STAMP = struct.Struct("<I"), struct.Struct("<II")


PADDING = tuple(bytes(-size % LENGTH.size) for size in range(LENGTH.size))
"""Padding that aligns a length, by the number of bytes before it modulo four."""


def put_length(data: bytearray, length: int) -> None:
    """Appends a length to the start of a message, with alignment."""
    data += PADDING[len(data) % LENGTH.size] + LENGTH.pack(length)


def put_texts(data: bytearray, texts: Iterable[str]) -> None:
    """Appends strings to the start of a message."""
    for text in texts:
        encoded = text.encode()
        data += b"%b%b%b\0" % (PADDING[len(data) % LENGTH.size], LENGTH.pack(len(encoded) + 1), encoded)


def mark(index: int) -> float:
    """The marker value of number `index` (from 0) in the message that becomes a template."""
    return -1e200 * (index + 1)


class Template:
    """A message of one type with `numbers` marks, each a float64, and any number of stamp marks.

    size: in bytes. places: indices of its numbers among the float64 of its body, in the order of the marks.
    """

    def __init__(self, kind: str, message: Any, numbers: int) -> None:
        if sys.byteorder != "little":
            raise NotImplementedError("CDR output supports only little-endian machines")
        self._bytes = bytearray(typestore().serialize_cdr(message, kind))
        self.size = len(self._bytes)
        self._bytes += bytes(-(self.size - HEAD) % DOUBLE)
        doubles = np.frombuffer(self._bytes, dtype="<f8", offset=HEAD)
        self.places = self._find(doubles, numbers, kind)
        words = np.frombuffer(self._bytes, dtype="<u4", offset=HEAD)
        stamps = np.flatnonzero((words[:-1] == SECONDS) & (words[1:] == NANOSECONDS))
        self._stamps = [HEAD + LENGTH.size * int(index) for index in stamps]

    @staticmethod
    def _find(doubles: npt.NDArray[np.float64], numbers: int, kind: str) -> npt.NDArray[np.intp]:
        marks = np.array([mark(i) for i in range(numbers)])
        order = np.argsort(doubles)
        places = order[np.searchsorted(doubles, marks, sorter=order)] if numbers else np.zeros(0, dtype=np.intp)
        if not np.array_equal(doubles[places], marks):
            raise ValueError(f"{kind}: not every mark is in the message")
        return places

    def fill(self, time: int, numbers: npt.NDArray[np.float64] = NONE) -> bytes:
        """The message at `time` [ns] with these numbers, in the order of their marks."""
        data = self._bytes.copy()
        if len(numbers):
            np.frombuffer(data, dtype="<f8", offset=HEAD)[self.places] = numbers
        stamp = STAMP.pack(*divmod(time, 1_000_000_000))
        for begin in self._stamps:
            data[begin : begin + STAMP.size] = stamp
        return bytes(memoryview(data)[: self.size])


class Series:
    """Messages of one type with a list of any length, whose items differ only in their numbers.

    build: makes a message with the given number of items; only the list may grow. numbers: number of marks per item,
    numbered consecutively over all items.
    """

    def __init__(self, kind: str, build: Callable[[int], Any], numbers: int) -> None:
        none, one, two, more = (Template(kind, build(count), count * numbers) for count in range(4))
        self._few, self._two = (none, one), two
        pairs = zip(two.fill(0), more.fill(0), strict=False)
        self._count_at = next(i for i, (before, after) in enumerate(pairs) if before != after)
        self._stride = more.size - two.size
        tail = none.size - self._count_at - LENGTH.size
        self._second = one.size - tail
        self._places = two.places[:numbers], two.places[numbers:]

    def fill(self, time: int, numbers: npt.NDArray[np.float64]) -> bytes:
        """The message at `time` [ns] with one item per row of numbers."""
        count = len(numbers)
        if count < len(self._few):
            return self._few[count].fill(time, numbers.reshape(-1))
        two, end = self._two.fill(time), self._second + self._stride
        data = bytearray(two[: self._second] + two[self._second : end] * (count - 1) + two[end:])
        LENGTH.pack_into(data, self._count_at, count)
        size = len(data)
        data += bytes(-(size - HEAD) % DOUBLE)
        first, second = self._places
        doubles = np.frombuffer(data, dtype="<f8", offset=HEAD)
        doubles[first] = numbers[0]
        doubles[second + self._stride // DOUBLE * np.arange(count - 1)[:, None]] = numbers[1:]
        return bytes(memoryview(data)[:size])
