"""The colors of all plots and of the pit wall."""

from __future__ import annotations

INK = "#22272e"
FAINT = "#9aa4af"
PAPER = "#ffffff"
ROAD = "#eef1f4"
WALL = "#c4ccd3"
GRID = "#edf0f2"
LEFT = "#1f77b4"
RIGHT = "#e8710a"
DROPPED = "#b4bcc4"
PAIR = "#8fa3b3"
LINE = "#2e7d32"
PATH = "#6a1b9a"
RETURN = LEFT
FREE = LINE
GOOD = LINE
BAD = "#c62828"
SPEED_MAP = "turbo"
"""Name of the matplotlib colormap."""


def rgb(color: str, paler: float = 0.0) -> tuple[int, int, int]:
    """Red, green, blue, 0 to 255; `paler`: fraction of white mixed in."""
    value = int(color.removeprefix("#"), 16)
    red, green, blue = (round(c + paler * (255 - c)) for c in (value >> 16, value >> 8 & 255, value & 255))
    return red, green, blue
