"""Text for people, some of it from file names."""

from __future__ import annotations

from pathlib import Path

UNKNOWN = "not known"
"""What stands where nothing was measured."""
ENDINGS = (".yaml", ".yml", ".csv", ".npz", ".mcap", ".bag", ".db3", ".zstd", ".zst", ".active")


def printable(text: str) -> str:
    """`text` as UTF-8 can hold it: bytes of a file name that are none become question marks."""
    return text.encode("utf-8", "replace").decode("utf-8")


def short_name(name: str) -> str:
    """A track's or recording's name for a title: of a path the file's name alone, without its ending.

    A name that a file gives itself may hold a slash, too; a path is what has a known ending or begins like one.
    """
    path, known = Path(name), Path(name).suffix.lower() in ENDINGS
    while path.suffix.lower() in ENDINGS:  # .mcap.zstd
        path = path.with_suffix("")
    return (path.name if known else path.stem) if known or name.startswith(("/", "./", "../")) else name


def short_names(names: list[str]) -> dict[str, str]:
    """Each name's short one; the whole name where two would be called the same."""
    short = {name: short_name(name) for name in names}
    taken = list(short.values())
    return {name: one if taken.count(one) == 1 else name for name, one in short.items()}


def counted(number: int, noun: str) -> str:
    """1 seed, 2 seeds."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def signed(value: float, digits: int, width: int = 0) -> str:
    """With its sign; what is nothing after rounding has a plus, never -0.0."""
    return f"{round(value, digits) + 0.0:+{width}.{digits}f}"


def to_side(value: float, positive: str, negative: str, spec: str = "g") -> str:
    """A distance [m] without its sign, and the side that it lies to: 0.1 m behind."""
    return f"{abs(value):{spec}} m {positive if value >= 0.0 else negative}"
