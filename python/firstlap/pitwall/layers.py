"""The layers that can be shown and hidden, each under its own scene node."""

from __future__ import annotations

from dataclasses import dataclass

MAP = "/map"
"""The root of all drawings, in the map frame."""


@dataclass(frozen=True)
class Layer:
    """node: root of the layer. title, doc: for display. shown: initially visible."""

    node: str
    title: str
    doc: str
    shown: bool = True


GROUND = Layer(f"{MAP}/ground", "Ground", "grid lines every meter, darker every five meters")
WALLS = Layer(f"{MAP}/walls", "True walls", "if known; dashed: not visible to the LiDAR")
MIDDLE = Layer(f"{MAP}/middle", "True centerline", "if known", shown=False)
LAPS = Layer(f"{MAP}/laps", "Last laps", "driven lines of the last laps; the best one is green")
RETURNS = Layer(f"{MAP}/returns", "Returns", "returns of this scan: right wall, left wall, and dropped ones")
REMEMBERED = Layer(f"{MAP}/remembered", "Local walls", "occluded wall points from earlier scans, paler")
WIDTHS = Layer(f"{MAP}/widths", "Track width", "pairs of opposite wall points")
LINE = Layer(f"{MAP}/line", "Centerline", "equally far from both walls; for driver global: its racing line")
CLEANED = Layer(f"{MAP}/cleaned", "Smoothed", "the smoothed centerline and its simplified points", shown=False)
PATH = Layer(f"{MAP}/path", "Path", "colored by planned speed")
BEFORE = Layer(f"{MAP}/before", "Path of the loaded setup", "for the same scan, if a changed setup is tried")
AIM = Layer(f"{MAP}/aim", "Aim", "the lookahead point; for other drivers: their aim and free space")
BODY = Layer(f"{MAP}/body", "Car", "wheels at the measured steering angle; arrow: commanded steering angle")

KNOWN = Layer(f"{MAP}/known", "Known map", "walls in the map of driver global, at its estimated pose")

LAYERS = (RETURNS, REMEMBERED, WIDTHS, LINE, CLEANED, PATH, BEFORE, AIM, BODY, LAPS, KNOWN, WALLS, MIDDLE, GROUND)
