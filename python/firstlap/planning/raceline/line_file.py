"""Reads and writes lines in the format of f1tenth_racetracks' raceline files.

Three comment lines, then s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2, the first point repeated at the end.
psi is 0 along +y there (heading minus pi/2, as in TUM's tools); our reader computes the heading from x, y.
"""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np

from firstlap.common.errors import InputError
from firstlap.common.files import check_writable, write_whole
from firstlap.common.version import __version__
from firstlap.common.yaml_text import read_text
from firstlap.config.car_file import Car
from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.line import RaceLine, check_clear, line_through
from firstlap.tracks.track import FloatArray, Track

SUFFIXES = (".csv",)
COLUMNS = "s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2"
FEWEST = 16


def write_line(line: RaceLine, path: str | FilePath) -> None:
    """Writes the file atomically. Raises InputError."""
    last = [line.length, *line.path.points[0], line.path.heading[0], line.path.curvature[0], line.speed[0]]
    rows = np.column_stack([line.path.stations, line.path.poses, line.path.curvature, line.speed, line.acceleration])
    rows = np.vstack([rows, [*last, line.acceleration[0]]])
    rows[:, 3] = np.remainder(rows[:, 3] - 0.5 * np.pi + np.pi, 2.0 * np.pi) - np.pi
    header = f"firstlap {__version__}, {' '.join(line.name.split())}\nlap {line.lap_time:.3f} s\n{COLUMNS}"
    write_whole(
        check_writable(path, SUFFIXES),
        lambda name: np.savetxt(name, rows, fmt="%.7f", delimiter="; ", header=header),
    )


def read_line(path: str | FilePath) -> RaceLine:
    """The line in a file. Raises InputError with the row and the fault."""
    path = FilePath(path)
    rows = _rows(read_text(path, "a raceline CSV file"), str(path))
    points, speed = rows[:, 1:3], rows[:, 5]
    if np.hypot(*(points[-1] - points[0])) < 1e-3:
        points, speed = points[:-1], speed[:-1]
    _check_closed(points, str(path))
    if (speed <= 0.0).any():
        raise InputError(f"{path}: row {int(np.argmax(speed <= 0.0)) + 1} has speed {speed.min():g}; expected above 0")
    return line_through(path.stem, points, speed, str(path))


def load_line(path: str | FilePath, track: Track, car: Car) -> RaceLine:
    """The line in a file, for a car on a track. Raises InputError, also if the car touches a wall on it."""
    line = read_line(path)
    check_clear(line, Corridor(track, car), str(path))
    return line


def _rows(text: str, where: str) -> FloatArray:
    rows = []
    for number, content in enumerate(text.splitlines(), start=1):
        if not content.strip() or content.lstrip().startswith("#"):
            continue
        try:
            values = [float(value) for value in content.split(";")]
        except ValueError:
            raise InputError(f"{where}: line {number} is not numbers separated by ';': {content[:40]!r}") from None
        if len(values) != 7:
            raise InputError(f"{where}: line {number} has {len(values)} columns; expected 7: {COLUMNS}")
        if not np.isfinite(values).all():
            raise InputError(f"{where}: line {number} has a value that is not finite")
        rows.append(values)
    if len(rows) < FEWEST:
        raise InputError(f"{where}: {len(rows)} points; expected a closed line of at least {FEWEST}")
    return np.array(rows)


def _check_closed(points: FloatArray, where: str) -> None:
    step = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    usual = float(np.median(step))
    if (step < 1e-6).any():
        raise InputError(f"{where}: points {int(np.argmin(step)) + 1} and the next are the same")
    if step[-1] > 3.0 * usual:
        raise InputError(f"{where}: the line is not closed: its ends are {step[-1]:.2f} m apart")
    if step.max() > 3.0 * usual:
        at = int(np.argmax(step))
        raise InputError(f"{where}: a gap of {step.max():.2f} m after point {at + 1}; expected evenly spaced points")
