"""Reads centerline CSV files as published by f1tenth_racetracks, f1tenth_benchmarks and TUM's racetrack-database.

A row is x, y, width to the right, width to the left, in meters, separated by `,`, `;` or blanks; comments begin with #.
A header line with column names, with or without #, may change the order. The line is closed; its direction of travel
and its start are those of the file.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import shapely

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import read_text
from firstlap.tracks.assemble import assemble
from firstlap.tracks.corridor import SAME, check_line, corridor_walls, spline_line
from firstlap.tracks.map_region import PLAUSIBLE
from firstlap.tracks.track import FloatArray, Track

COLUMNS = ("x", "y", "width right", "width left")
NAMES = {"x": r"x(_m)?", "y": r"y(_m)?", "width right": r"w.*(right|_r)(_m)?", "width left": r"w.*(left|_l)(_m)?"}
"""Patterns of column names, in lower case."""
RACELINE = 7
"""Columns of TUM's raceline files: s, x, y, heading, curvature, speed, acceleration."""
EXPECTED = "a centerline CSV: x, y, width right, width left in each row [m]"
MAX_BYTES = 4_000_000
MIN_POINTS, MAX_POINTS = 8, 20_000
"""Number of points of a line."""
MAX_CLOSING_GAP = 4.0
"""Gap between the ends of a closed line, as a multiple of its largest other step."""
FULL_SIZE = 0.1
"""Scale of full-size circuits, as in f1tenth_racetracks; tracks wider than any for small cars are scaled by it."""


def load_centerline(path: str | Path) -> Track:
    """The track in a CSV file. Raises InputError with file, row and expected content."""
    path = Path(path)
    return parse_centerline(read_text(path, EXPECTED, MAX_BYTES), str(path))


def parse_centerline(text: str, where: str) -> Track:
    """The track in the text of a CSV file; `where` names the file in messages. Raises InputError."""
    notes: list[str] = []
    points = _scaled(_closed(_in_order(*_rows(text, where), where), where, notes), notes)
    check_line(points, "the centerline", where)
    ahead = points[1, :2] - points[0, :2]
    try:
        left, right = corridor_walls(spline_line(points), where)
        start = (float(points[0, 0]), float(points[0, 1]), float(np.arctan2(ahead[1], ahead[0])))
        return assemble(Path(where).stem, [left], [right], [], source=where, start=start, notes=notes)
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise InputError(f"{where}: cannot be made into a track ({error})") from None


def _rows(text: str, where: str) -> tuple[FloatArray, list[str]]:
    """(N, M) numbers, and the column names if the file has them."""
    rows: list[list[float]] = []
    names: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        cells = _cells(line.lstrip("# \t"))
        if not cells:
            continue
        values = None if line.lstrip().startswith("#") else _numbers(cells)
        if values is None and not rows:
            names = cells
            continue
        if line.lstrip().startswith("#"):
            continue
        if values is None:
            raise InputError(f"{where}: line {number} is not numbers: {line[:40]!r}; expected {EXPECTED}")
        if rows and len(values) != len(rows[0]):
            raise InputError(f"{where}: line {number} has {len(values)} columns, those before have {len(rows[0])}")
        rows.append(values)
        if len(rows) > MAX_POINTS:
            raise InputError(f"{where}: more than {MAX_POINTS} points; expected about one every 0.1 m")
    if len(rows) < MIN_POINTS:
        raise InputError(f"{where}: {len(rows)} points; expected {EXPECTED}, at least {MIN_POINTS} of them")
    return np.array(rows), [name.lower() for name in names]


def _cells(line: str) -> list[str]:
    """The cells of a line, separated by `;`, `,` or blanks, whichever of them it contains first in this order."""
    separator = next((mark for mark in (";", ",") if mark in line), None)
    return [cell.strip() for cell in line.strip().rstrip(";,").split(separator)] if line.strip() else []


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _in_order(rows: FloatArray, names: list[str], where: str) -> FloatArray:
    """The columns in the order of `COLUMNS`."""
    count = rows.shape[1]
    if count == RACELINE:
        raise InputError(
            f"{where}: {count} columns, as in a raceline file (s, x, y, heading, curvature, speed, acceleration), "
            f"which has no walls; expected {EXPECTED}"
        )
    found = [at for column in COLUMNS if (at := _position(NAMES[column], names)) is not None]
    if len(names) == count and len(found) == len(COLUMNS):
        return rows[:, found]
    if count != len(COLUMNS):
        raise InputError(f"{where}: {count} columns; expected {EXPECTED}")
    return rows


def _position(pattern: str, names: list[str]) -> int | None:
    return next((at for at, name in enumerate(names) if re.fullmatch(pattern, name)), None)


def _closed(points: FloatArray, where: str, notes: list[str]) -> FloatArray:
    """The line without repeated points. Raises InputError if its ends are far apart."""
    steps = np.hypot(*(np.roll(points[:, :2], -1, axis=0) - points[:, :2]).T)
    repeated = steps < SAME
    if repeated[:-1].any():
        notes.append(f"dropped {int(repeated[:-1].sum())} repeated points")
    points, steps = points[~repeated], steps[~repeated]
    if len(points) < MIN_POINTS:
        raise InputError(f"{where}: {len(points)} different points; expected at least {MIN_POINTS}")
    gap = float(np.hypot(*(points[0, :2] - points[-1, :2])))
    largest = float(np.hypot(*np.diff(points[:, :2], axis=0).T).max())
    if gap > MAX_CLOSING_GAP * largest:
        raise InputError(f"{where}: the line is not closed: its ends are {gap:.2f} m apart")
    return points


def _scaled(points: FloatArray, notes: list[str]) -> FloatArray:
    width = float(np.median(points[:, 2] + points[:, 3]))
    if width <= PLAUSIBLE[1]:
        return points
    notes.append(f"{width:.1f} m wide, a full-size circuit: scaled 1:{1 / FULL_SIZE:.0f}")
    return points * FULL_SIZE
