"""Maps from a slow lap and from recordings: accurate, complete, or refused with a one-line error."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car, parse_car
from firstlap.drivers.mapping_drive import map_track
from firstlap.evaluation.map_accuracy import check_map, true_start
from firstlap.mapping import make
from firstlap.mapping.make import MapResult, map_observations
from firstlap.mapping.observation import Observation, motion_of
from firstlap.mapping.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap, read_map, write_map
from firstlap.mapping.parameters import map_settings
from firstlap.mapping.poses import between, compose, transform
from firstlap.mapping.slam import Mapper
from firstlap.tracks.library import load_track
from firstlap.tracks.map_header import parse_ros_map_yaml
from firstlap.tracks.track import Track

Cli = Callable[..., Any]
SCANS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "scans"


@pytest.fixture(scope="module")
def oval() -> Track:
    return load_track("oval")


@pytest.fixture(scope="module")
def mapped(oval: Track) -> MapResult:
    return map_track(oval)


def test_going_there_and_back_is_standing_still() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-3, 3, (2, 50, 3))
    np.testing.assert_allclose(compose(a, between(a, b)), b, atol=1e-12)
    np.testing.assert_allclose(transform(np.array([1, 2, np.pi / 2]), np.array([[1.0, 0.0]])), [[1, 3]], atol=1e-12)


def test_odometry_goes_round_a_quarter_circle() -> None:
    pose = np.zeros(3)
    for _ in range(100):
        pose = compose(pose, motion_of(np.pi / 2, np.pi / 2, 0.01))
    np.testing.assert_allclose(pose, [1.0, 1.0, np.pi / 2], atol=1e-4)


def test_walls_of_a_map_lie_within_two_centimeters_of_the_true_ones(oval: Track, mapped: MapResult) -> None:
    error = check_map(mapped.map, oval, true_start(oval, load_car("default")))
    assert error.rms < 0.02
    assert error.rms_start < 0.03
    assert error.complete > 0.99
    assert mapped.map.start == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_wheels_that_turn_three_percent_too_much_do_not_stretch_the_map(oval: Track) -> None:
    car = parse_car("sensors:\n  speed_scale_error: 0.03\n  yaw_rate_bias: 0.01\n", "biased.yaml")
    result = map_track(oval, car=car)
    assert result.odometry_scale == pytest.approx(1 / 1.03, abs=0.01)
    assert check_map(result.map, oval, true_start(oval, car)).rms < 0.03


def test_a_sweep_longer_than_the_usual_period_is_not_undone_even_after_a_lost_scan() -> None:
    """The scan after a lost one is used, with the usual scan period."""
    room, speed, sweep = firstlap.Lidar(load_track("oval")), 2.0, 0.15
    x, y, yaw = load_track("oval").start_pose()
    ranges = room.scan(x, y, yaw)
    clouds = []
    for time_increment in (0.0, sweep / (len(ranges) - 1)):
        scan = _core.LaserScan(ranges, room.angles[0], float(np.diff(room.angles)[0]), time_increment, 0.05, 30.0)
        mapper = Mapper(map_settings(), load_car("default").core)
        for time, motion in ((0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.4, 0.5)):
            mapper.add(Observation(time, speed, 0.5, np.array([motion, 0.0, 0.0]), lambda scan=scan: scan))
        clouds.append(mapper.keyframes[-1].cloud)
        assert len(mapper.keyframes) == 2
    np.testing.assert_array_equal(*clouds)


def test_the_check_sees_a_map_that_is_wrong(oval: Track, mapped: MapResult) -> None:
    drawn = mapped.map
    x, y, yaw = drawn.origin
    stretched = OccupancyMap(drawn.cells, drawn.resolution * 1.05, (x * 1.05, y * 1.05, yaw), drawn.start)
    start = true_start(oval, load_car("default"))
    assert check_map(stretched, oval, start).rms > 0.08
    shifted = OccupancyMap(drawn.cells, drawn.resolution, (x + 0.2, y, yaw), drawn.start)
    error = check_map(shifted, oval, start)
    assert error.rms_start > 0.1
    assert error.rms < 0.02, "the best rigid fit takes a shift away"


def test_a_written_map_is_read_and_raced_in_the_same_direction(oval: Track, mapped: MapResult, tmp_path: Path) -> None:
    write_map(mapped.map, tmp_path / "oval.yaml")
    back = read_map(tmp_path / "oval.yaml")
    np.testing.assert_array_equal(back.cells, mapped.map.cells)
    assert back.origin == pytest.approx(mapped.map.origin, abs=1e-6)
    track = load_track(str(tmp_path / "oval.yaml"))
    assert track.length == pytest.approx(oval.length, rel=0.02)
    x, y, yaw = track.start_pose()
    assert np.hypot(x, y) < 0.3
    assert abs(yaw) < 0.1, "base_link looked along x when the lap began"
    assert firstlap.race(track, laps=1).finished


def test_a_map_has_the_levels_and_thresholds_of_map_server(tmp_path: Path) -> None:
    cells = np.array([[FREE, OCCUPIED, UNKNOWN], [UNKNOWN, FREE, FREE]], dtype=np.uint8)
    write_map(OccupancyMap(cells, 0.05, (-1.0, 2.0, 0.0), (0.0, 0.0, 0.5)), tmp_path / "m.yaml")
    data = (tmp_path / "m.pgm").read_bytes()
    assert data.startswith(b"P5\n")
    assert data[-6:] == bytes([205, 254, 254, 254, 0, 205]), "the highest row comes first"
    header = parse_ros_map_yaml((tmp_path / "m.yaml").read_text(), "m.yaml")
    occupancy = (255 - np.array([254, 0, 205])) / 255
    assert occupancy[0] < header.free_thresh < occupancy[2] < header.occupied_thresh < occupancy[1]
    assert header.starting_positions == ((0.0, 0.0, 0.5),)


def test_the_same_seed_draws_the_same_map_and_another_seed_another(oval: Track, mapped: MapResult) -> None:
    again = map_track(oval)
    np.testing.assert_array_equal(again.map.cells, mapped.map.cells)
    other = map_track(oval, seed=2)
    assert other.map.cells.shape != mapped.map.cells.shape or (other.map.cells != mapped.map.cells).any()


def test_the_command_writes_map_and_picture_and_says_how_true_it_is(cli: Cli, tmp_path: Path) -> None:
    ran = cli("map", "oval", "-o", "oval.yaml", "--check", "--json", "--plot", "oval.png")
    assert ran.code == 0, ran.err
    assert ran.json["error"]["rms"] < 0.05
    assert ran.json["loops"] > 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["oval.pgm", "oval.png", "oval.yaml"]


def test_an_interrupt_leaves_no_half_written_map(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(make, "optimize", interrupt)
    assert cli("map", "oval", "-o", "oval.yaml").code == 130
    monkeypatch.undo()
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(Path, "chmod", interrupt)
    cells = np.zeros((3, 3), dtype=np.uint8)
    with pytest.raises(KeyboardInterrupt):
        write_map(OccupancyMap(cells, 0.05, (0.0, 0.0, 0.0)), tmp_path / "half.yaml")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("oval", "-o", "map.png"), ".yaml"),
        (("oval", "-o", "nowhere/map.yaml"), "no such folder"),
        (("oval", "-o", "map.yaml", "--set", "grid.resolutoin=0.05"), "did you mean grid.resolution"),
        (("oval", "-o", "map.yaml", "--set", "grid.resolution=5"), "0.01 to 0.2 m"),
        (("oval", "-o", "map.yaml", "--set", "match.reach_first=0.06"), "match.reach_last"),
        (("ovall", "-o", "map.yaml"), "did you mean oval"),
        (("nothing.npz", "-o", "map.yaml"), "no such file"),
        (("oval", "-o", "map.yaml", "--set", "drive.give_up=5"), "no loop was closed in 5"),
        (("oval", "-o", "map.yaml", "--set", "drive.speed=10", "--setup", "gap"), "gap"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(
    cli: Cli, tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    ran = cli("map", *arguments)
    assert ran.code == 2
    assert words in ran.err
    assert ran.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def _recording(path: Path, **changes: Any) -> None:
    count, angles = 60, np.linspace(-2.35, 2.35, 541)
    corridor = np.minimum(1.0 / np.maximum(np.abs(np.sin(angles)), 0.01), 40.0)
    arrays: dict[str, Any] = {
        "ranges": np.tile(corridor, (count, 1)).astype(np.float32),
        "angle_min": -2.35,
        "angle_increment": 4.7 / 540,
        "stamps": 0.025 * np.arange(count),
        "speed": np.full(count, 2.0),
        "yaw_rate": np.zeros(count),
        **changes,
    }
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "no loop was closed in 3.0"),
        ({"speed": None, "yaw_rate": None}, "no odometry"),
        ({"ranges": None}, "ranges"),
        ({"ranges": np.full((60, 541), np.nan, dtype=np.float32)}, "no valid scan: 0 of 541 beams return"),
    ],
)
def test_a_recording_that_gives_no_map_says_why(cli: Cli, tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    _recording(tmp_path / "bad.npz", **changes)
    ran = cli("map", "bad.npz", "-o", "map.yaml")
    assert ran.code == 2
    assert words in ran.err
    assert ran.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["bad.npz"]
    assert "true walls are known" in cli("map", "bad.npz", "-o", "map.yaml", "--check").err


def test_odometry_that_jumps_is_refused() -> None:
    scan = _core.LaserScan(np.ones(10, dtype=np.float32), -1.0, 0.2, 0.0, 0.1, 10.0)
    motions = [np.zeros(3), np.array([np.nan, 0.0, 0.0])]
    seen = [Observation(0.1 * i, 1.0, 0.0, motion, lambda: scan) for i, motion in enumerate(motions)]
    with pytest.raises(InputError, match=r"odometry at 0\.100 s jumps"):
        map_observations(seen, load_car("default"), name="jump", total=2)


def test_without_gtsam_one_line_says_what_to_install(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gtsam", None)
    ran = cli("map", "oval", "-o", "map.yaml")
    assert ran.code == 2
    assert "mapping needs gtsam: `make extras`" in ran.err


def test_parameters_reach_the_core() -> None:
    settings = map_settings(["grid.resolution=0.05"])
    grid = _core.OccupancyGrid(0.0, 0.0, 4, 1, settings.core)
    for _ in range(2):
        grid.add((0.01, 0.01, 0.0), (0.0, 0.0), np.array([[0.12, 0.0, 0.12]]))
    assert grid.cells().tolist() == [[0, 0, 1, 2]]


@pytest.mark.skipif(not SCANS.is_dir(), reason="the shared recordings are not here")
def test_a_real_recording_gives_a_track_that_can_be_raced(cli: Cli) -> None:
    ran = cli("map", SCANS / "germany2022/germany2022.npz", "-o", "real.yaml", "--json")
    assert ran.code == 0, ran.err
    track = load_track("real.yaml")
    assert track.length == pytest.approx(33.2, abs=0.7), "the length that its authors' centerline has"
    assert firstlap.race(track, laps=1).finished
