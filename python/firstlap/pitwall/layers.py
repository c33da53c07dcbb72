"""What can be shown and hidden, each under a node of its own."""

from __future__ import annotations

from dataclasses import dataclass

MAP = "/map"
"""Holds all that is drawn, in the map frame."""


@dataclass(frozen=True)
class Layer:
    """node: everything of the layer hangs under it. title, doc: for people. shown: to begin with."""

    node: str
    title: str
    doc: str
    shown: bool = True


GROUND = Layer(f"{MAP}/ground", "Ground", "a line every meter, a darker one every five")
WALLS = Layer(f"{MAP}/walls", "True walls", "where known; dashed: what the LiDAR does not see")
MIDDLE = Layer(f"{MAP}/middle", "True middle", "where known", shown=False)
LAPS = Layer(f"{MAP}/laps", "Last laps", "lines of the last laps; the best one is green")
RETURNS = Layer(f"{MAP}/returns", "Returns", "of this scan: right and left wall, and what was dropped")
REMEMBERED = Layer(f"{MAP}/remembered", "Remembered", "of scans before, paler")
WIDTHS = Layer(f"{MAP}/widths", "Track width", "pairs of opposite wall points")
LINE = Layer(f"{MAP}/line", "Centerline", "equally far from both walls; of driver global: its line")
CLEANED = Layer(
    f"{MAP}/cleaned", "Smoothed", "the centerline on its way to a path, and the points that are kept of it", shown=False
)
PATH = Layer(f"{MAP}/path", "Path", "colored by planned speed")
BEFORE = Layer(f"{MAP}/before", "Path before", "of the loaded setup over the same scan, where another one is tried")
AIM = Layer(f"{MAP}/aim", "Aim", "the lookahead point; of other drivers: where they aim, and what is free")
BODY = Layer(f"{MAP}/body", "Car", "wheels at the measured angle; the arrow is the commanded one")

KNOWN = Layer(f"{MAP}/known", "Known map", "walls of its map, as driver global believes to see them")

LAYERS = (RETURNS, REMEMBERED, WIDTHS, LINE, CLEANED, PATH, BEFORE, AIM, BODY, LAPS, KNOWN, WALLS, MIDDLE, GROUND)
