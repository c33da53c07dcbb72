"""Perception metrics: closed forms, simulated scans, and real scans if available."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.perception import map_comparison, metrics
from firstlap.evaluation.perception.detections import Detection
from firstlap.evaluation.perception.ground_truth import LEFT, NEITHER, RIGHT, UNKNOWN, GroundTruth
from firstlap.evaluation.perception.metrics import Perception
from firstlap.evaluation.perception.simulated import measure
from firstlap.recordings import Recording, load_recording
from firstlap.tracks.library import load_track

WIDTH = 2.0
LENGTH = 40.0
SHARED = Path(__file__).resolve().parents[4] / "shared" / "data"
AHEAD = ("0.5", "1", "2", "3")


@pytest.fixture(scope="module")
def corridor() -> GroundTruth:
    """A straight along x, 2 m wide, closed far away."""
    x = np.arange(0.0, LENGTH, 0.05)
    line = np.vstack([np.column_stack([x, 0.0 * x]), np.column_stack([x[::-1], 0.0 * x + 50.0])])
    wall = np.arange(0.0, LENGTH, 0.02)
    walls = np.vstack([np.column_stack([wall, 0.0 * wall + y]) for y in (1.0, -1.0)])
    sides = np.repeat([LEFT, RIGHT], len(wall)).astype(np.int8)
    return GroundTruth(line, np.full(len(line), WIDTH), walls, sides)


def seen_in_corridor(
    *, offset: float = 0.0, swapped: bool = False, reach: float = 5.0, width: float = WIDTH
) -> Detection:
    """The detection of a car at (10, 0) in the corridor; its line is `offset` to the left."""
    x = np.arange(-1.0, reach + 0.331, 0.15)
    wall = np.arange(-1.5, 8.0, 0.1)
    points = np.vstack([np.column_stack([wall, 0.0 * wall - 1.0]), np.column_stack([wall, 0.0 * wall + 1.0])])
    side = np.repeat([RIGHT, LEFT], len(wall)).astype(np.int8)
    line = np.column_stack([x, 0.0 * x + offset])
    return Detection(
        status="ok",
        points=points,
        side=-side if swapped else side,
        line=line,
        line_width=np.full(len(x), width),
        path=line[x >= 0.33],
        left=points[side == LEFT],
        right=points[side == RIGHT],
        front=0.33,
    )


def perceived(truth: GroundTruth, *scans: tuple[Detection, tuple[float, float, float]]) -> dict:
    perception = Perception(truth)
    for seen, pose in scans:
        perception.add(seen, pose, 0.025)
    return perception.to_dict()


def test_a_true_line_has_no_error_and_true_labels_are_all_right(corridor):
    found = perceived(corridor, (seen_in_corridor(), (10.0, 0.0, 0.0)))
    for ahead in AHEAD:
        assert found["error"][ahead]["p95"] == 0.0
        assert found["width_error"][ahead]["p95"] == 0.0
    assert (found["precision"], found["recall"], found["bad"], found["no_line"]) == (1.0, 1.0, 0.0, 0.0)
    assert found["available"] == {"1": 1.0, "2": 1.0, "3": 1.0}


@pytest.mark.parametrize("offset", [0.2, -0.3])
def test_a_shifted_line_is_off_by_exactly_its_shift(corridor, offset):
    found = perceived(corridor, (seen_in_corridor(offset=offset), (10.0, 0.0, 0.0)))
    for ahead in AHEAD:
        assert found["error"][ahead]["median"] == pytest.approx(abs(offset), abs=1e-4)
        assert found["error"][ahead]["bias"] == pytest.approx(offset, abs=1e-4)
    assert found["bad"] == 0.0


def test_the_error_is_that_of_the_place_not_of_the_cars_pose(corridor):
    found = perceived(corridor, (seen_in_corridor(offset=-0.4), (10.0, 0.4, 0.0)))
    assert found["error"]["2"]["median"] == pytest.approx(0.0, abs=1e-4)
    turned = perceived(corridor, (seen_in_corridor(), (10.0, -0.0330, 0.1)))
    assert turned["error"]["2"]["median"] == pytest.approx(2.0 * np.sin(0.1), abs=2e-3)


def test_swapped_labels_have_precision_0_and_recall_0(corridor):
    found = perceived(corridor, (seen_in_corridor(swapped=True), (10.0, 0.0, 0.0)))
    assert (found["precision"], found["recall"]) == (0.0, 0.0)


def test_a_return_without_a_label_costs_recall_not_precision(corridor):
    seen = seen_in_corridor()
    side = seen.side.copy()
    side[: len(side) // 2] = NEITHER
    found = perceived(corridor, (replace(seen, side=side), (10.0, 0.0, 0.0)))
    assert found["precision"] == 1.0
    assert found["recall"] == pytest.approx(0.5, abs=0.01)


def test_what_no_wall_explains_is_not_judged_and_said(corridor):
    seen = seen_in_corridor()
    points = seen.points.copy()
    points[:10, 1] -= 0.5
    found = perceived(corridor, (replace(seen, points=points), (10.0, 0.0, 0.0)))
    assert (found["precision"], found["recall"]) == (1.0, 1.0)
    assert found["not_judged"] == pytest.approx(10 / len(points), abs=1e-4)
    both = corridor.side_of(np.array([[10.0, 0.0]]), 1.5)
    assert both[0] == UNKNOWN


def test_scenery_labelled_as_wall_is_wrong(corridor):
    sides = corridor.sides.copy()
    sides[sides == LEFT] = NEITHER
    found = perceived(replace(corridor, sides=sides), (seen_in_corridor(), (10.0, 0.0, 0.0)))
    assert found["precision"] == pytest.approx(0.5)
    assert found["recall"] == 1.0


def test_bad_is_no_line_at_2_m_or_more_than_half_a_metre_off_there(corridor):
    scans = [
        seen_in_corridor(reach=1.9),
        seen_in_corridor(offset=0.51),
        seen_in_corridor(offset=0.49),
        seen_in_corridor(),
    ]
    found = perceived(corridor, *[(seen, (10.0, 0.0, 0.0)) for seen in scans])
    assert found["bad"] == 0.5
    assert found["available"] == {"1": 1.0, "2": 0.75, "3": 0.75}
    assert found["error"]["2"]["scans"] == 3


def test_width_error_is_the_planners_width_against_the_tracks(corridor):
    found = perceived(corridor, (seen_in_corridor(width=2.3), (10.0, 0.0, 0.0)))
    assert found["width_error"]["1"]["median"] == pytest.approx(0.3, abs=1e-4)


def test_the_cars_own_motion_is_no_jump(corridor):
    still = seen_in_corridor()
    found = perceived(corridor, (still, (10.0, 0.0, 0.0)), (still, (10.1, 0.0, 0.0)))
    assert found["jump"] == {"median": 0.0, "p95": 0.0, "big": 0.0}
    moved = perceived(corridor, (still, (10.0, 0.0, 0.0)), (seen_in_corridor(offset=0.2), (10.1, 0.0, 0.0)))
    assert moved["jump"]["p95"] == pytest.approx(0.2, abs=1e-4)
    assert moved["jump"]["big"] == 1.0
    assert moved["metres"] == pytest.approx(0.1)


def test_a_change_of_side_is_counted_per_scan_and_per_metre(corridor):
    seen = seen_in_corridor()
    swapped = replace(seen, left=seen.right, right=seen.left)
    scans = [(one, (10.0 + 0.1 * i, 0.0, 0.0)) for i, one in enumerate([seen, seen, swapped, swapped, seen])]
    found = perceived(corridor, *scans)
    assert found["changes_of_side"] == 2
    assert found["changes_per_metre"] == pytest.approx(2 / 0.4, abs=1e-3)
    assert found["changes_per_scan"] == pytest.approx(2 / 5)


def test_ahead_counts_along_the_line_from_beside_the_front_axle():
    angle = np.linspace(-0.5, 1.5, 400)
    way, points = metrics.foot(np.column_stack([0.33 + 3.0 * np.sin(angle), 3.0 - 3.0 * np.cos(angle)]), 0.33)
    assert metrics.at(way, points, 2.0)[0] == pytest.approx(
        [0.33 + 3.0 * np.sin(2 / 3), 3.0 - 3.0 * np.cos(2 / 3)], abs=1e-3
    )
    assert np.isnan(metrics.at(way, points, 5.0)).all()
    late, _ = metrics.foot(np.array([[1.33, 0.0], [3.33, 0.0]]), 0.33)
    assert late == pytest.approx([1.0, 3.0])


def test_the_truth_is_midway_between_the_walls_and_its_sides_turn_with_the_direction():
    track = load_track("hairpins")
    forward, back = GroundTruth.of(track), GroundTruth.of(track.reversed())
    from firstlap.tracks.medial import distances

    left = [w for w, side in zip(track.walls, track.sides, strict=True) if side == "left"]
    right = [w for w, side in zip(track.walls, track.sides, strict=True) if side == "right"]
    assert np.percentile(np.abs(distances(forward.line, left) - distances(forward.line, right)), 99) < 0.01
    assert (forward.side_of(forward.walls[::50], 0.1) == -back.side_of(forward.walls[::50], 0.1)).all()


@pytest.mark.parametrize(("name", "reverse"), [("oval", True), ("slalom", False)])
def test_on_our_tracks_the_walls_and_the_line_are_seen_right(name, reverse):
    track = load_track(name)
    perception, outcome = measure(track.reversed() if reverse else track, load_setup("sure"), load_car("default"))
    found = perception.to_dict()
    assert outcome == "finished"
    assert found["bad"] <= 0.01
    assert min(found["precision"], found["recall"]) >= 0.98
    for ahead in ("0.5", "1", "2"):
        assert found["error"][ahead]["median"] <= 0.03
        assert found["error"][ahead]["p95"] <= 0.20


def real_track() -> tuple[Path, Path]:
    scans, track_map = SHARED / "scans/germany2022/germany2022.npz", SHARED / "maps/germany2022/germany2022.yaml"
    if not (scans.is_file() and track_map.is_file()):
        pytest.skip(f"no shared data in {SHARED}")
    return scans, track_map


def test_on_a_real_track_the_walls_and_the_line_are_seen_right(tmp_path):
    scans, track_map = real_track()
    recording = load_recording(scans).between(20.0, 40.0)
    found = map_comparison.measure(recording, load_setup("sure"), load_car("default"), track_map)
    metrics_found = found.to_dict()
    assert metrics_found["turns"] == 0
    assert metrics_found["bad"] <= 0.04
    assert min(metrics_found["precision"], metrics_found["recall"]) >= 0.97
    for ahead in ("0.5", "1", "2"):
        assert metrics_found["error"][ahead]["median"] <= 0.04
        assert metrics_found["error"][ahead]["p95"] <= 0.35
    found.plot(tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 10_000


def test_a_recording_without_poses_cannot_be_held_against_a_map():
    scans = np.full((3, 100), 2.0, dtype=np.float32)
    recording = Recording(
        name="still",
        source="still.npz",
        ranges=list(scans),
        headers=np.tile([-2.0, 0.04, 0.0, 0.1, 30.0], (3, 1)),
        start=0.0,
        stamps=np.array([0.0, 0.1, 0.2]),
        dts=np.full(3, 0.1),
        states=np.zeros((3, 3)),
        sources={},
    )
    with pytest.raises(InputError, match="no poses"):
        map_comparison.measure(recording, load_setup("sure"), load_car("default"), "nowhere.yaml")


def test_the_command_prints_a_row_per_direction(cli):
    ran = cli("perception", "oval", "--both", "--json")
    assert ran.code == 0
    rows = ran.json["runs"]
    assert [(row["track"], row["direction"]) for row in rows] == [("oval", "forward"), ("oval", "reverse")]
    assert all(row["no_line"] == 0.0 and row["precision"] > 0.98 for row in rows)


def test_replay_holds_a_recording_against_its_map(cli):
    scans, track_map = real_track()
    ran = cli("replay", scans, "--map", track_map, "--from", 20, "--to", 30, "--plot", "map.png", "--json")
    assert ran.code == 0
    assert ran.json["against_map"]["scans"] == ran.json["scans"]
    assert ran.json["against_map"]["bad"] <= 0.04
    assert Path("map.png").stat().st_size > 10_000
    other = cli("replay", SHARED / "scans/rollcage/rollcage.npz", "--map", track_map)
    assert other.code == 2
    assert "its poses are from odometry" in other.err
