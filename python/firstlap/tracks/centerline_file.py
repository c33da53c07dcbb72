"""Centerlines as CSV files, as f1tenth_racetracks, f1tenth_benchmarks and TUM's racetrack-database publish them.

A row is x, y, width to the right, width to the left, in meters, with `,`, `;` or blanks between; comments begin with #.
A line of names above the rows, with or without #, may give another order. The line is closed and driven as it is
written, from its first point.
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
"""Patterns of what the columns are called, in small letters."""
RACELINE = 7
"""Columns of TUM's raceline files: s, x, y, heading, curvature, speed, acceleration."""
EXPECTED = "a centerline CSV: x, y, width right, width left in each row [m]"
MAX_BYTES = 4_000_000
FEWEST, MOST = 8, 20_000
"""Points of a line."""
WIDEST_GAP = 4.0
"""Between the ends of a closed line, in its other largest steps."""
FULL_SIZE = 0.1
"""The scale of a circuit that is wider than any track of small cars: as f1tenth_racetracks has them."""


def load_centerline(path: str | Path) -> Track:
    """The track in a CSV file. Raises InputError naming the file, the row and what would be right."""
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
        raise InputError(f"{where}: no track can be made of it ({error})") from None


def _rows(text: str, where: str) -> tuple[FloatArray, list[str]]:
    """(N, M) numbers, and the names of the columns where the file has them."""
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
        if len(rows) > MOST:
            raise InputError(f"{where}: more than {MOST} points; expected one every 0.1 m or so")
    if len(rows) < FEWEST:
        raise InputError(f"{where}: {len(rows)} points; expected {EXPECTED}, at least {FEWEST} of them")
    return np.array(rows), [name.lower() for name in names]


def _cells(line: str) -> list[str]:
    """What stands between the first of `;`, `,` or blanks that the line has."""
    separator = next((mark for mark in (";", ",") if mark in line), None)
    return [cell.strip() for cell in line.strip().rstrip(";,").split(separator)] if line.strip() else []


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _in_order(rows: FloatArray, names: list[str], where: str) -> FloatArray:
    """The columns as of `COLUMNS`."""
    count = rows.shape[1]
    if count == RACELINE:
        raise InputError(
            f"{where}: {count} columns, as a raceline has them (s, x, y, heading, curvature, speed, acceleration): it "
            f"says nothing of walls; expected {EXPECTED}"
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
    """The line with each point once; its ends must be near each other."""
    steps = np.hypot(*(np.roll(points[:, :2], -1, axis=0) - points[:, :2]).T)
    repeated = steps < SAME
    if repeated[:-1].any():
        notes.append(f"left out {int(repeated[:-1].sum())} points that repeat the one before")
    points, steps = points[~repeated], steps[~repeated]
    if len(points) < FEWEST:
        raise InputError(f"{where}: {len(points)} different points; expected at least {FEWEST}")
    gap = float(np.hypot(*(points[0, :2] - points[-1, :2])))
    largest = float(np.hypot(*np.diff(points[:, :2], axis=0).T).max())
    if gap > WIDEST_GAP * largest:
        raise InputError(f"{where}: the line is not closed: its ends are {gap:.2f} m apart")
    return points


def _scaled(points: FloatArray, notes: list[str]) -> FloatArray:
    width = float(np.median(points[:, 2] + points[:, 3]))
    if width <= PLAUSIBLE[1]:
        return points
    notes.append(f"{width:.1f} m wide, a circuit of full size: scaled 1:{1 / FULL_SIZE:.0f}")
    return points * FULL_SIZE
