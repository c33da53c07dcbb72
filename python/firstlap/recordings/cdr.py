"""Fast serialization of messages that differ only in their numbers from scan to scan.

The library serializes a message once, with marker values in place of its numbers and stamps. Their offsets are located
in the bytes, and every further message is a copy with its own numbers at these offsets.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.recordings.messages import typestore

SECONDS, NANOSECONDS = 0x5A5B5C5D, 0x0DEADBEE
"""The marker value of a stamp."""
HEAD = 4
"""Bytes before the body of a CDR message; what follows is aligned to its start."""


def mark(index: int) -> float:
    """The marker value of number `index` (from 0) in the message that becomes a template."""
    return -1e200 * (index + 1)


class Template:
    """A message of one type with `numbers` marks, each a float64, and any number of stamp marks."""

    def __init__(self, kind: str, message: Any, numbers: int) -> None:
        if sys.byteorder != "little":
            raise NotImplementedError("CDR output supports only little-endian machines")
        self._bytes = bytearray(typestore().serialize_cdr(message, kind))
        self._size = len(self._bytes)
        self._bytes += bytes(-(self._size - HEAD) % 8)
        doubles = np.frombuffer(self._bytes, dtype="<f8", offset=HEAD)
        self._places = self._find(doubles, numbers, kind)
        words = np.frombuffer(self._bytes, dtype="<u4", offset=HEAD)
        self._stamps = np.flatnonzero((words[:-1] == SECONDS) & (words[1:] == NANOSECONDS))

    @staticmethod
    def _find(doubles: npt.NDArray[np.float64], numbers: int, kind: str) -> npt.NDArray[np.intp]:
        marks = np.array([mark(i) for i in range(numbers)])
        order = np.argsort(doubles)
        places = order[np.searchsorted(doubles, marks, sorter=order)] if numbers else np.zeros(0, dtype=np.intp)
        if not np.array_equal(doubles[places], marks):
            raise ValueError(f"{kind}: not every mark is in the message")
        return places

    def fill(self, time: int, numbers: npt.NDArray[np.float64]) -> bytes:
        """The message at `time` [ns] with these numbers, in the order of their marks."""
        data = self._bytes.copy()
        np.frombuffer(data, dtype="<f8", offset=HEAD)[self._places] = numbers
        words = np.frombuffer(data, dtype="<u4", offset=HEAD)
        words[self._stamps], words[self._stamps + 1] = divmod(time, 1_000_000_000)
        return bytes(memoryview(data)[: self._size])
