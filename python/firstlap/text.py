"""Text that may come from file names."""

from __future__ import annotations


def printable(text: str) -> str:
    """`text` as UTF-8 can hold it: bytes of a file name that are none become question marks."""
    return text.encode("utf-8", "replace").decode("utf-8")
