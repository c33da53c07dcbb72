"""Whether a car can drive laps of a track at all, without reverse."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS, Car
from firstlap.config.parameters import FieldTable
from firstlap.sim.lidar import core_track
from firstlap.tracks.track import Track

SEARCH_FIELDS = FieldTable(_core.LapSearchOptions.fields())
"""Safety distance and resolution of the search."""
DEFAULT_MARGIN = float(SEARCH_FIELDS.find("margin", "lap_search").default)
"""[m]"""
MARGIN_STEP, MAX_MARGIN = 0.01, 0.3
RADIUS_STEP, MAX_RADIUS = 0.05, 1.5
"""Steps and upper ends [m] of `Drivable.largest_margin` and `largest_radius`."""
LIMIT_REFINEMENTS, LIMIT_STATES = 1, 1_000_000
"""Effort of the searches for these limits: less than for the answer itself."""
CORNER_BEFORE, CORNER_AFTER = 1.0, 2.0
"""Distance [m] along the centerline before and after the farthest place within which the corner is looked for."""


@dataclass(frozen=True)
class Place:
    """A place on a track: x, y [m] in the map frame, s [m] along the centerline, width [m] of the track there, and the
    radius [m] of the centerline's curve."""

    x: float
    y: float
    s: float
    width: float
    radius: float


@dataclass(frozen=True, eq=False)
class LapSearch:
    """The result of one search.

    verdict: drivable; blocked: no state gets farther; undecided: too many states. traveled: farthest progress [m].
    path: (N, 3) x, y, yaw of base_link, at most 0.05 m apart: a closed lap from index `lap_start` on, with the way to
    it; otherwise the way to the farthest state.
    """

    verdict: str
    traveled: float
    states: int
    lap_start: int
    path: npt.NDArray[np.float64] = field(repr=False)

    @property
    def drivable(self) -> bool:
        """Whether a lap was found."""
        return self.verdict == "drivable"


@dataclass(frozen=True, eq=False)
class Drivable:
    """Whether, and how easily, a car can drive laps of a track in its direction.

    search: with `margin` [m] around the car's rectangle. turning_radius: of the car [m].
    largest_margin: with which laps are drivable [m], up to `MAX_MARGIN`; None: not even without.
    largest_radius: of turning, with which laps are drivable with `margin` [m], up to `MAX_RADIUS`; None: not even with
    the smallest that a car can have.
    blocked_at, corner: where the search gets no farther, and the tightest curve of the centerline there; None if
    drivable.
    """

    search: LapSearch
    margin: float
    turning_radius: float
    largest_margin: float | None
    largest_radius: float | None
    blocked_at: Place | None
    corner: Place | None


def turning_radius(car: Car) -> float:
    """Radius [m] of the smallest circle of base_link: wheelbase / tan(steering limit)."""
    geometry = car.core.values()["geometry"]
    return _radius(geometry["wheelbase"], geometry["steering_limit"])


def _radius(wheelbase: float, steering_angle: float) -> float:
    return wheelbase / math.tan(steering_angle)


def search_lap(track: Track, car: Car, **options: float) -> LapSearch:
    """Searches for a lap from the start pose in the track's direction; options: of `SEARCH_FIELDS`. Raises InputError.

    A lap that is found is a proof. That none is found holds for the resolution of the search: cells, then headings,
    halved `refinements` times where it gets no farther.
    """
    chosen = _core.LapSearchOptions()
    try:
        for name, value in options.items():
            chosen.set("lap_search", name, value)
    except ValueError as error:
        raise InputError(str(error)) from None
    found = _core.search_lap(core_track(track), car.core, chosen)
    return LapSearch(path=np.array(found.pop("path")), **found)


def drivable(track: Track, car: Car, margin: float, **options: float) -> Drivable:
    """The answer of a search with this margin [m], and the limits that other searches find. Raises InputError."""
    search = search_lap(track, car, margin=margin, **options)
    quick = {**options, "refinements": LIMIT_REFINEMENTS, "max_states": LIMIT_STATES}

    def with_margin(steps: int) -> bool:
        return search_lap(track, car, **{**quick, "margin": steps * MARGIN_STEP}).drivable

    def with_radius(steps: int) -> bool:
        return search_lap(track, _with_radius(car, steps * RADIUS_STEP), **{**quick, "margin": margin}).drivable

    margins = _largest(with_margin, 0, round(MAX_MARGIN / MARGIN_STEP))
    radii = _largest(with_radius, math.ceil(_smallest_radius(car) / RADIUS_STEP), round(MAX_RADIUS / RADIUS_STEP))
    place = None if search.drivable else _place_at(track, search.traveled, search.path[-1])
    return Drivable(
        search=search,
        margin=margin,
        turning_radius=turning_radius(car),
        largest_margin=None if margins is None else margins * MARGIN_STEP,
        largest_radius=None if radii is None else radii * RADIUS_STEP,
        blocked_at=place,
        corner=None if place is None else _tightest(track, place.s),
    )


def _largest(holds: Callable[[int], bool], low: int, high: int) -> int | None:
    """The largest number from low to high for which it holds, if it holds up to there; None if for none."""
    if holds(high):
        return high
    if not holds(low):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _with_radius(car: Car, radius: float) -> Car:
    core = _core.Car(car.core)
    core.set("geometry", "steering_limit", math.atan(car.core.values()["geometry"]["wheelbase"] / radius))
    return Car(car.name, core, car.source)


def _smallest_radius(car: Car) -> float:
    wheelbase = car.core.values()["geometry"]["wheelbase"]
    return _radius(wheelbase, CAR_FIELDS.find("geometry.steering_limit", "car").max)


def _place_at(track: Track, traveled: float, pose: npt.NDArray[np.float64]) -> Place:
    s = traveled % track.length
    index = int(np.argmin(np.abs(track.stations[:-1] - s)))
    return Place(float(pose[0]), float(pose[1]), s, float(track.width[index]), float(_radii(track)[index]))


def _tightest(track: Track, s: float) -> Place:
    ahead = (track.stations[:-1] - s + 0.5 * track.length) % track.length - 0.5 * track.length
    radii = np.where((ahead >= -CORNER_BEFORE) & (ahead <= CORNER_AFTER), _radii(track), np.inf)
    index = int(np.argmin(radii))
    x, y = track.centerline[index]
    return Place(float(x), float(y), float(track.stations[index]), float(track.width[index]), float(radii[index]))


def _radii(track: Track) -> npt.NDArray[np.float64]:
    from firstlap.tracks.medial import curvature  # needs scipy, which takes long to import

    return np.asarray(1.0 / np.maximum(np.abs(curvature(track.centerline)), 1e-6))
