"""Tracks: the track files, random tracks, and invariants of every Track."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from firstlap.common.errors import InputError
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.medial import curvature, distances, medial_line
from firstlap.tracks.random_track import random_track
from firstlap.tracks.track import Track
from firstlap.tracks.track_file import load_track_file, parse_track

OVAL = """
corners:
  - [0, 0, 2.4, 0.9, 0.9]
  - [12, 0, 2.4, 0.9, 0.9]
  - [12, 5, 2.4, 0.9, 0.9]
  - [0, 5, 2.4, 0.9, 0.9]
"""


def circle(radius: float) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def solid_gap_free(track: Track, side: str) -> bool:
    """Whether the solid walls of a side join up into closed rings: every end meets another end."""
    ends = [wall[i] for wall, s, solid in zip(track.walls, track.sides, track.solid, strict=True)
            if s == side and solid and not np.allclose(wall[0], wall[-1]) for i in (0, -1)]  # fmt: skip
    return all(sum(np.hypot(*(end - other)) < 1e-6 for other in ends) == 2 for end in ends)


def check(track: Track) -> None:
    line = track.centerline
    step = np.hypot(*(np.roll(line, -1, axis=0) - line).T)
    assert step.min() > 0.08
    assert step.max() < 0.12
    assert shapely.LinearRing(line).is_simple
    for side, width, sign in (("left", track.width_left, 1.0), ("right", track.width_right, -1.0)):
        walls = [w for w, s, solid in zip(track.walls, track.sides, track.solid, strict=True) if s == side and solid]
        np.testing.assert_allclose(distances(line, walls), width, atol=1e-6)
        assert solid_gap_free(track, side)
        nearest = shapely.shortest_line(shapely.points(line), shapely.MultiLineString(walls))
        to_wall = shapely.get_coordinates(nearest).reshape(-1, 2, 2)[:, 1] - line
        tangent = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
        assert (sign * (tangent[:, 0] * to_wall[:, 1] - tangent[:, 1] * to_wall[:, 0]) > 0).all()
    assert np.abs(track.width_left - track.width_right).max() < 0.35
    arrays = track.to_arrays()
    assert arrays["segments"].shape == (len(arrays["visible"]), 4) and len(arrays["solid"]) == len(arrays["visible"])
    assert np.isfinite(arrays["segments"]).all()


def test_the_medial_line_of_an_annulus_is_the_circle_midway() -> None:
    line = medial_line([circle(3.0)], [circle(5.0)], "annulus")
    np.testing.assert_allclose(np.hypot(*line.T), 4.0, atol=0.01)
    np.testing.assert_allclose(curvature(line), 0.25, atol=0.02)
    clockwise = medial_line([circle(5.0)], [circle(3.0)], "annulus")
    np.testing.assert_allclose(curvature(clockwise), -0.25, atol=0.02)


@pytest.mark.parametrize("name", list_tracks())
def test_our_tracks_keep_every_promise_in_both_directions(name: str) -> None:
    track = load_track(name)
    assert track.name == name
    check(track)
    check(track.reversed())
    assert 25.0 < track.length < 100.0


def test_there_are_at_least_ten_tracks_of_our_own() -> None:
    assert len(list_tracks()) >= 10


@pytest.mark.parametrize("seed", range(12))
def test_random_tracks_are_drivable(seed: int) -> None:
    track = random_track(seed)
    check(track)
    narrow, _, wide = track.width_summary()
    assert 30.0 <= track.length <= 100.0
    assert narrow >= 1.1
    assert wide <= 3.1


def test_the_same_seed_gives_the_same_track_and_another_seed_another() -> None:
    np.testing.assert_array_equal(random_track(5).centerline, random_track(5).centerline)
    assert random_track(5).length != random_track(6).length


def test_reversing_keeps_the_start_and_swaps_the_sides() -> None:
    track = load_track("arena")
    back = track.reversed()
    x, y, yaw = track.start_pose()
    bx, by, byaw = back.start_pose()
    assert (bx, by) == pytest.approx((x, y))
    assert np.cos(byaw - yaw) == pytest.approx(-1.0)
    assert back.width_left[0] == track.width_right[0]
    np.testing.assert_array_equal(back.reversed().centerline, track.centerline)


def test_start_poses_lie_along_the_lap() -> None:
    track = load_track("oval")
    ahead, behind = track.start_pose(1.0), track.start_pose(-1.0)
    assert np.hypot(ahead[0] - behind[0], ahead[1] - behind[1]) == pytest.approx(2.0, abs=0.01)
    assert track.start_pose(track.length)[:2] == pytest.approx(track.start_pose()[:2])


def test_low_walls_and_joints_are_solid_but_not_seen() -> None:
    for name in ("low_wall", "pipes"):
        track = load_track(name)
        hidden = [wall for wall, seen in zip(track.walls, track.visible, strict=True) if not seen]
        lengths = [shapely.LineString(wall).length for wall in hidden]
        assert hidden and max(lengths) < 0.5
        assert all(hard for hard, seen in zip(track.solid, track.visible, strict=True) if not seen)
    low = load_track("low_wall")
    scenery = [hard for hard, side in zip(low.solid, low.sides, strict=True) if side == "scenery"]
    assert scenery and not any(scenery)


def test_the_arena_is_the_kind_of_track_the_paper_raced_on() -> None:
    track = load_track("arena")
    narrow, median, wide = track.width_summary()
    assert track.length == pytest.approx(50.0, abs=2.0)
    assert narrow >= 1.39 and median == pytest.approx(1.9, abs=0.1) and wide <= 2.35


def test_a_spline_through_points_makes_the_same_kind_of_track() -> None:
    points = [[round(x, 4), round(y, 4), 1.0, 0.8] for x, y in circle(4.0)[:-1:60].tolist()]
    track = parse_track(f"name: ring\ncenterline: {points}\n", "ring.yaml")
    np.testing.assert_allclose(np.hypot(*track.centerline.T), 4.1, atol=0.02)


def test_explicit_walls_make_a_track_with_an_obstacle() -> None:
    walls = [
        {"side": "left", "points": circle(3.0)[::10].tolist()},
        {"side": "right", "points": circle(5.0)[::10].tolist()},
        {"side": "obstacle", "points": [[4.0, 0.0], [4.2, 0.0], [4.2, 0.2]]},
    ]
    track = parse_track(f"walls: {walls}", "walls.yaml")
    assert track.sides == ["left", "right", "obstacle"]
    assert np.hypot(*(np.array(track.start_pose()[:2]) - [4.1, 0.1])) > 0.5


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected 'key: value'"),
        ("[1, 2]", "key: value"),
        ("name: x", "expected one of corners"),
        (OVAL + "speed: 3", "unknown key 'speed'"),
        (OVAL.replace("2.4", ".nan", 1), "finite number"),
        (OVAL.replace("2.4", "4.0"), "their arcs need"),
        (OVAL.replace("0.9", "0.05"), "width outside"),
        (OVAL.replace("0.9", "3.5"), "too wide"),
        (OVAL.replace("0.9", "0.16"), "narrowest"),
        ("corners: [[0, 0, 1, 1, 1], [5, 0, 1, 1, 1]]", "3 or more"),
        ("corners: [[0, 0, 1, 1], [5, 0, 1, 1, 1], [5, 5, 1, 1, 1]]", "expected 5 numbers"),
        ("corners: [[0, 0, 1, 1, 1], [9, 9, 1, 1, 1], [9, 0, 1, 1, 1], [0, 9, 1, 1, 1]]", "overlaps itself"),
        (OVAL + "pipes: {length: 1}", "expected {length, joint}"),
        (OVAL + "pipes: {length: 1, joint: -1}", "joints above 0"),
        (OVAL + "low_wall: [{side: up, from: 1, to: 2, post: 1, gap: 1}]", "left or right"),
        (OVAL + "low_wall: [{side: left, from: 9, to: 2, post: 1, gap: 1}]", "from < to"),
        (OVAL + "start: [1]", "start is"),
        ("walls: [{side: left, points: [[0, 0], [1, 0], [1, 1]]}]", "one left and one right"),
        ("a: &a [1]\nb: *a", "aliases"),
        ("a: [1", "not YAML"),
    ],
)
def test_a_wrong_track_file_says_in_one_line_what_would_be_right(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        parse_track(text, "some.yaml")
    assert str(caught.value).startswith("some.yaml") and "\n" not in str(caught.value)


@pytest.mark.parametrize("spec", ["random:", "random:-1", "random:x", "arenna", "no/such.yaml", "", "\0", "x" * 5000])
def test_an_unknown_track_is_an_input_error(spec: str) -> None:
    with pytest.raises(InputError):
        load_track(spec)


def test_a_misspelt_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(InputError, match="arena"):
        load_track("arenna")


def test_a_file_loads_by_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(OVAL)
    assert load_track(str(path)).length == pytest.approx(load_track_file(path).length)
    assert load_track(str(path)).name == "mine"
