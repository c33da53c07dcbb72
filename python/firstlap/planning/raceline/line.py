"""The racing line of a track for a car: shape, speeds, and clearance to the walls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.minimum_curvature import minimum_curvature
from firstlap.planning.raceline.minimum_time import minimum_time
from firstlap.planning.raceline.params import LineParams, limits_of
from firstlap.planning.raceline.path import Path, closed_spline, path_through, resampled
from firstlap.planning.raceline.velocity import profile
from firstlap.tracks.track import FloatArray, Track

TOLERANCE = 0.01
"""[m] Tolerance of the margin."""


@dataclass(frozen=True, eq=False)
class RaceLine:
    """A closed line for base_link with speeds; the first point is at the start line, not repeated.

    path: points, heading, curvature. speed (N,) [m/s] at the points; acceleration (N,) [m/s^2] to the next point.
    """

    name: str
    path: Path
    speed: FloatArray
    acceleration: FloatArray
    source: str = ""
    notes: list[str] = field(default_factory=list)

    @property
    def length(self) -> float:
        """Length of a lap in meters."""
        return self.path.length

    @property
    def lap_time(self) -> float:
        """Time [s] of a flying lap at these speeds."""
        return float(np.sum(2.0 * self.path.step / (self.speed + np.roll(self.speed, -1))))


def make_line(
    track: Track, car: Car, params: LineParams | None = None, tell: Callable[[str, float], None] | None = None
) -> RaceLine:
    """The minimum-time line of a car between the walls of a track.

    tell: called with the current activity and its progress. Raises InputError if the car cannot pass.
    """
    params = params or LineParams()
    say = tell or (lambda _what, _share: None)
    limits, corridor = limits_of(car, params), Corridor(track, car)
    points = minimum_curvature(track.centerline, corridor, limits, params, lambda share: say("curvature", share))
    if params.time_rounds:
        points = minimum_time(points, corridor, limits, params, lambda share: say("lap time", share))
    path = _from_start(points, track, params.spacing)
    speeds = profile(path.curvature, path.step, limits)
    line = RaceLine(track.name, path, speeds.speed, speeds.acceleration, track.source or track.name)
    return RaceLine(**{**vars(line), "notes": _judged(line, corridor, params, limits.curvature)})


def _from_start(points: FloatArray, track: Track, spacing: float) -> Path:
    """The path with its first point at the track's start."""
    spline, length = closed_spline(points)
    fine = np.linspace(0.0, length, 20 * len(points), endpoint=False)
    begin = fine[int(np.argmin(np.hypot(*(spline(fine) - track.centerline[0]).T)))]
    return resampled(points, spacing, float(begin))


def _judged(line: RaceLine, corridor: Corridor, params: LineParams, sharpest: float) -> list[str]:
    """Remarks on a tight line. Raises InputError if the car touches a wall on it."""
    check_clear(line, corridor, line.source)
    clearance = corridor.clearance(line.path.poses)
    notes = []
    if clearance.min() < params.margin - TOLERANCE:
        where = line.path.stations[int(np.argmin(clearance))]
        notes.append(f"the car only just fits: {clearance.min():.3f} m to the wall at s = {where:.1f} m")
    bend = np.abs(line.path.curvature)
    if bend.max() > 1.02 * sharpest:
        where = line.path.stations[int(np.argmax(bend))]
        notes.append(f"the corner at s = {where:.1f} m requires more steering than steering_use allows")
    return notes


def check_clear(line: RaceLine, corridor: Corridor, where: str) -> None:
    """Raises InputError with the s of the first contact if the car's rectangle on the line touches a wall."""
    touching = np.flatnonzero(corridor.clearance(line.path.poses) <= 0.0)
    if len(touching):
        s = line.path.stations[touching[0]]
        raise InputError(
            f"{where}: the line takes the car into a wall at s = {s:.1f} m "
            f"({len(touching)} of {len(line.speed)} points touch); expected a line clear of the walls"
        )


def line_through(name: str, points: FloatArray, speed: FloatArray, source: str) -> RaceLine:
    """A line through given points (N, 2), first not repeated, with speeds (N,) [m/s]."""
    path = path_through(points)
    after = np.roll(speed, -1)
    return RaceLine(name, path, speed, (after**2 - speed**2) / (2.0 * path.step), source)
