"""Whether a car can drive laps of a track: our own tracks, made-up corridors, and the laws of the answer."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely import affinity

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, load_car, parse_car
from firstlap.sim.drivable import drivable, search_lap, turning_radius
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track
from firstlap.tracks.track_file import parse_track

CAR = load_car("default")


def square(width: float) -> Track:
    """Four lanes of `width` m around a rectangle, with tight corners of 90 degrees."""
    corners = [[x, y, 0.55 * width, 0.5 * width, 0.5 * width] for x, y in ((0, 0), (6, 0), (6, 4), (0, 4))]
    return parse_track(f"corners: {corners}", "square.yaml")


def body(pose: np.ndarray, margin: float) -> shapely.Polygon:
    """The car's rectangle as a polygon, in the map frame."""
    geometry = CAR.core.values()["geometry"]
    rear, side = geometry["rear_overhang"], 0.5 * geometry["width"]
    box = shapely.box(-rear - margin, -side - margin, geometry["length"] - rear + margin, side + margin)
    turned = affinity.rotate(box, pose[2], origin=(0, 0), use_radians=True)
    return affinity.translate(turned, pose[0], pose[1])


@pytest.mark.parametrize("name", list_tracks())
def test_every_track_of_ours_is_drivable_both_ways(name: str) -> None:
    for track in (load_track(name), load_track(name).reversed()):
        found = search_lap(track, CAR, margin=0.05)
        assert found.drivable and found.traveled > 0.8 * track.length


def test_a_found_lap_is_clear_of_the_walls_by_the_margin() -> None:
    track = load_track("narrow")
    solid = shapely.MultiLineString([wall for wall, hard in zip(track.walls, track.solid, strict=True) if hard])
    shapely.prepare(solid)
    found = search_lap(track, CAR, margin=0.2)
    assert found.drivable
    assert not any(body(pose, 0.2 - 1e-9).intersects(solid) for pose in found.path)
    closed = found.path[-1] - found.path[found.lap_start]
    assert np.hypot(*closed[:2]) < 1e-6 and math.remainder(closed[2], math.tau) == pytest.approx(0.0, abs=1e-6)


def with_geometry(**values: float) -> Car:
    listed = "".join(f"  {name}: {value}\n" for name, value in values.items())
    return parse_car(f"geometry:\n{listed}", "car.yaml")


def test_what_is_easier_is_drivable_too() -> None:
    """A smaller margin, a smaller turning circle and a smaller car do not make a lap impossible."""
    track = square(0.9)
    margins = [search_lap(track, CAR, margin=margin).drivable for margin in (0.0, 0.04, 0.08, 0.14, 0.2)]
    limits = [search_lap(track, with_geometry(steering_limit=limit)).drivable for limit in (0.6, 0.4189, 0.2, 0.12)]
    lengths = [search_lap(track, with_geometry(length=length)).drivable for length in (0.5, 0.58, 0.9, 1.4)]
    for answers in (margins, limits, lengths):
        assert answers == sorted(answers, reverse=True), answers
        assert answers[0] and not answers[-1]


def test_the_limits_agree_with_the_answer_and_a_corner_is_named() -> None:
    easy = drivable(square(0.9), CAR, 0.02)
    assert easy.search.drivable and easy.blocked_at is None and easy.corner is None
    assert easy.largest_margin is not None and 0.02 <= easy.largest_margin < 0.3
    assert easy.largest_radius is not None and easy.largest_radius > turning_radius(CAR)
    wide = with_geometry(steering_limit=0.12)
    hard = drivable(square(0.9), wide, 0.02)
    assert hard.search.verdict == "blocked" and hard.largest_margin is None
    assert hard.largest_radius == pytest.approx(easy.largest_radius, abs=0.05)
    assert hard.corner is not None and hard.corner.radius < turning_radius(wide)
    assert hard.blocked_at is not None and 0.0 < hard.blocked_at.s < square(0.9).length


def test_a_finer_search_gives_the_same_answer() -> None:
    for width in (0.5, 0.55, 0.8, 0.9):
        track = square(width)
        coarse, fine = search_lap(track, CAR), search_lap(track, CAR, cell=0.05, headings=144)
        assert coarse.verdict == fine.verdict, width


def test_an_invalid_option_is_an_input_error() -> None:
    with pytest.raises(InputError, match=r"lap_search\.margin = -1"):
        search_lap(load_track("oval"), CAR, margin=-1.0)
