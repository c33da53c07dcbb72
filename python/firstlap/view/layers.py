"""What can be shown and hidden, each under a node of its own."""

from __future__ import annotations

from dataclasses import dataclass

MAP = "/map"
"""Holds what stands still, in the map frame."""
CAR = "/car"
"""Holds what moves with the car, in base_link."""


@dataclass(frozen=True)
class Layer:
    """node: everything of the layer hangs under it. title, doc: for people. shown: to begin with."""

    node: str
    title: str
    doc: str
    shown: bool = True


GROUND = Layer(f"{MAP}/ground", "Ground", "a line every metre, a darker one every five")
WALLS = Layer(f"{MAP}/walls", "True walls", "where known; dashed: what the LiDAR does not see")
MIDDLE = Layer(f"{MAP}/middle", "True centerline", "where known", shown=False)
LAPS = Layer(f"{MAP}/laps", "Last laps", "lines of the last laps; the best one is green")
RETURNS = Layer(f"{CAR}/returns", "Returns", "of this scan: right and left wall, and what was dropped")
REMEMBERED = Layer(f"{CAR}/remembered", "Remembered walls", "of scans before, paler")
WIDTHS = Layer(f"{CAR}/widths", "Track width", "pairs of opposite wall points")
LINE = Layer(f"{CAR}/line", "Centerline", "equally far from both walls; of driver global: its line")
CLEANED = Layer(f"{CAR}/cleaned", "Smoothed, simplified", "the centerline on its way to a path", shown=False)
PATH = Layer(f"{CAR}/path", "Path", "coloured by planned speed")
AIM = Layer(f"{CAR}/aim", "Aim", "the lookahead point; of other drivers: where they aim, and what is free")
BODY = Layer(f"{CAR}/body", "Car", "wheels at the measured angle; the arrow is the commanded one")

KNOWN = Layer(f"{CAR}/known", "Known map", "walls of its map, as driver global believes to see them")

LAYERS = (RETURNS, REMEMBERED, WIDTHS, LINE, CLEANED, PATH, AIM, BODY, LAPS, KNOWN, WALLS, MIDDLE, GROUND)
