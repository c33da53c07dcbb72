"""Formatting of names and numbers for output."""

from __future__ import annotations

from pathlib import Path

UNKNOWN = "not known"
"""Text for a value that was not measured."""
ENDINGS = (".yaml", ".yml", ".csv", ".npz", ".mcap", ".bag", ".db3", ".zstd", ".zst", ".active")


def printable(text: str) -> str:
    """`text` as valid UTF-8: invalid bytes of a file name become question marks."""
    return text.encode("utf-8", "replace").decode("utf-8")


def short_name(name: str) -> str:
    """A track's or recording's name for a title: for a path, the file name without its suffix.

    A name that is set in a file may also contain a slash; a path has a known suffix or starts with /, ./ or ../.
    """
    path, known = Path(name), Path(name).suffix.lower() in ENDINGS
    while path.suffix.lower() in ENDINGS:  # .mcap.zstd
        path = path.with_suffix("")
    return (path.name if known else path.stem) if known or name.startswith(("/", "./", "../")) else name


def short_names(names: list[str]) -> dict[str, str]:
    """The short name of each name; the whole name if two short names would be equal."""
    short = {name: short_name(name) for name in names}
    taken = list(short.values())
    return {name: one if taken.count(one) == 1 else name for name, one in short.items()}


def counted(number: int, noun: str) -> str:
    """The number with its noun: "1 seed", "2 seeds"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def signed(value: float, digits: int, width: int = 0) -> str:
    """The rounded value with its sign; zero has a plus, never -0.0."""
    return f"{round(value, digits) + 0.0:+{width}.{digits}f}"


def to_side(value: float, positive: str, negative: str, spec: str = "g") -> str:
    """A signed distance [m] as its magnitude and side: "0.1 m behind"."""
    return f"{abs(value):{spec}} m {positive if value >= 0.0 else negative}"
