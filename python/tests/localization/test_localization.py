"""The localizer tracks a racing car on a map from a slow lap, and detects when it is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.drivers.mapping_drive import map_track
from firstlap.evaluation.localization import Disturbance, Followed, follow
from firstlap.evaluation.localization_of_recording import localize_recording
from firstlap.localization.localizer import Estimate, Localizer, localizer_params
from firstlap.mapping.occupancy_map import OccupancyMap, write_map
from firstlap.recordings import load_recording
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

REST = _core.VehicleState()
Cli = Callable[..., Any]


@pytest.fixture(scope="module")
def track() -> Track:
    return load_track("width_step")


@pytest.fixture(scope="module")
def known(track: Track) -> OccupancyMap:
    return map_track(track).map


def _follow(track: Track, known: OccupancyMap, seed: int = 1, scans: int | None = None, **wrong: float) -> Followed:
    return follow(
        track,
        known,
        load_setup("race"),
        load_car("default"),
        laps=1,
        seed=seed,
        scans=scans,
        disturbance=Disturbance(**wrong),
    )


def test_at_racing_speed_on_a_map_of_its_own_it_stays_within_ten_centimeters(track: Track, known: OccupancyMap) -> None:
    followed = _follow(track, known)
    found = followed.to_dict()
    assert found["outcome"] == "finished"
    assert found["position"]["p95"] < 0.10
    assert found["heading"]["p95"] < 3.0
    assert found["lost"] < 0.02
    assert found["found_after"] < 0.3


def test_it_finds_itself_from_two_metres_and_45_degrees_away(track: Track, known: OccupancyMap) -> None:
    for seed in (1, 2):
        followed = _follow(track, known, seed=seed, start=2.0, heading=np.radians(45), scans=160)
        assert followed.recoveries()[0] is not None
        assert not followed.lost[-1]
        assert followed.distance[-1] < 0.1


def test_it_recovers_each_time_the_car_is_set_down_half_a_metre_elsewhere(track: Track, known: OccupancyMap) -> None:
    followed = _follow(track, known, kidnap=0.5, every=2.0)
    assert len(followed.kidnapped) >= 4
    assert all(seconds is not None for seconds in followed.recoveries())


def test_on_the_map_of_another_track_it_says_that_it_is_lost(cli: Cli, known: OccupancyMap) -> None:
    write_map(known, "other.yaml")
    ran = cli("localize", "wide", "--map", "other.yaml", "--laps", 1, "--json")
    assert ran.code == 1
    assert ran.json["lost"] > 0.5
    assert ran.json["lost_at_end"]


def test_the_same_seed_says_the_same(track: Track, known: OccupancyMap) -> None:
    first, again = _follow(track, known, scans=80), _follow(track, known, scans=80)
    np.testing.assert_array_equal(first.estimated, again.estimated)
    assert (_follow(track, known, seed=2, scans=80).estimated != first.estimated).any()


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 1e30])
def test_scans_without_sense_leave_it_lost_and_never_raise(known: OccupancyMap, value: float) -> None:
    localizer = Localizer(known, load_car("default"))
    ranges = np.full(1081, value, dtype=np.float32)
    assert localizer.step(_core.LaserScan(ranges), REST, 0.025).lost, "before it was started"
    localizer.start((0.0, 0.0, 0.0))
    for _ in range(20):
        scan, state = _core.LaserScan(ranges, angle_min=value), _core.VehicleState(value, value, value)
        estimate = localizer.step(scan, state, value)
    assert estimate.lost
    assert np.isfinite(tuple(estimate)[:6]).all()


def test_the_pose_is_predicted_along_an_arc(known: OccupancyMap) -> None:
    localizer = Localizer(known, load_car("default"), params=localizer_params(["motion.slip=0"]))
    at = Estimate(1.0, 2.0, np.pi / 2, 0.0, 0.0, 1.0, False, False)
    assert localizer.predict(at, _core.VehicleState(3.0), 0.1) == pytest.approx((1.0, 2.3, np.pi / 2))
    assert localizer.predict(at, _core.VehicleState(3.0, 1.0), 0.1)[2] == pytest.approx(np.pi / 2 + 0.1)


def test_a_map_without_walls_and_a_wrong_parameter_are_refused() -> None:
    empty = OccupancyMap(np.zeros((5, 5), dtype=np.uint8), 0.05, (0.0, 0.0, 0.0), source="empty.yaml")
    with pytest.raises(InputError, match=r"empty\.yaml: a map without an occupied cell"):
        Localizer(empty, load_car("default"))
    with pytest.raises(InputError, match=r"did you mean filter\.beams"):
        localizer_params(["filter.beam=9"])
    with pytest.raises(InputError, match=r"filter\.particles_min"):
        localizer_params(["filter.particles_min=5000"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("oval", "--map", "none.yaml"), "no such file"),
        (("oval", "--map", "empty.yaml"), "empty"),
        (("oval", "--set", "filter.beams=9000"), "5 to 400"),
        (("oval", "--setup", "nonsense"), "no such setup"),
    ],
)
def test_bad_input_is_one_line(cli: Cli, tmp_path: Path, arguments: tuple[str, ...], words: str) -> None:
    (tmp_path / "empty.yaml").touch()
    ran = cli("localize", *arguments)
    assert ran.code == 2
    assert words in ran.err
    assert ran.err.count("\n") == 1


@pytest.fixture(scope="module")
def log(track: Track, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a lap with the setup race."""
    path = tmp_path_factory.mktemp("log") / "lap.mcap"
    firstlap.race(track, "race", laps=1, record=path)
    return path


def test_a_recorded_car_is_followed_from_where_the_map_was_begun(log: Path, known: OccupancyMap) -> None:
    recorded = load_recording(log)
    found = localize_recording(recorded, known, load_car("default")).to_dict()
    assert found["scans"] == len(recorded)
    assert (found["start"], found["lost_at_end"]) == ([0.0, 0.0, 0.0], False)
    assert found["lost"] < 0.02
    assert found["position"]["p50"] is None, "the log's poses are in the track's frame"


def test_poses_of_the_map_are_begun_with_and_compared(log: Path, known: OccupancyMap) -> None:
    recorded, car = load_recording(log), load_car("default")
    whole = localize_recording(recorded, known, car)
    placed = replace(recorded, poses=whole.estimated, frame="map").between(6.0, 12.0)
    localized = localize_recording(placed, known, car)
    assert placed.poses is not None
    assert localized.start == tuple(placed.poses[0])
    assert localized.to_dict()["position"]["p95"] < 0.1
    assert localized.to_dict()["lost"] < 0.05


def test_localize_takes_a_recording_and_a_map(cli: Cli, tmp_path: Path, log: Path, known: OccupancyMap) -> None:
    drawn, other = tmp_path / "map.yaml", tmp_path / "oval.yaml"
    write_map(known, drawn)
    ran = cli("localize", log, "--map", drawn)
    assert ran.code == 0, ran.err
    assert "lap on map" in ran.out
    assert "lost in" in ran.out
    missing = f"{log}: a recording needs --map MAP, a map of its location; `firstlap map` makes one"
    assert cli("localize", log).err == f"error: {missing}\n"
    assert (
        cli("localize", log, "--map", drawn, "--kidnap", 1).err == "error: --kidnap: has no effect with a recording\n"
    )
    assert cli("localize", "oval", "--laser", "0,0,0").err == "error: --laser: has no effect with a track\n"
    write_map(map_track(load_track("oval")).map, other)
    lost = cli("localize", log, "--map", other, "--json")
    assert (lost.code, lost.json["lost_at_end"]) == (1, True)


def test_distances_are_those_of_the_map() -> None:
    cells = np.zeros((40, 40), dtype=np.uint8)
    cells[20, 20] = 1
    field = _core.LikelihoodField(cells, 0.05, (0.0, 0.0, 0.0))
    beams = np.array([[0.5, 0.0, 0.0, 0.0]])
    (x, y, _), fit = field.search(beams, (0.4, 1.0, 0.0), 0.3, 0.01, 0.05, 0.05)
    assert np.hypot(x + 0.5 - 1.025, y - 1.025) < 0.12, "a step of the raster either way"
    assert fit == pytest.approx(1.0, abs=1e-3)


def test_the_command_has_its_old_name_still(cli: Cli) -> None:
    assert "Usage: firstlap localise" in cli("localise", "--help").out
    assert "localise" not in cli("--help").out
