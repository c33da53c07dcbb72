"""The map-based driver: the whole chain on a small track, and its reaction to failures of each part."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.config.setup_file import Setup, choose_setup, load_setup
from firstlap.drivers.global_driver.drivable_area import road_of
from firstlap.evaluation.survey import Run, Survey
from firstlap.mapping.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap, without_gaps
from firstlap.mapping.poses import between
from firstlap.pitwall.sim_race import Plan, SimRace
from firstlap.pitwall.sim_source import SimSource
from firstlap.recordings.messages import typestore
from firstlap.ros.trace_message import TraceHeader, messages_of, topics_of
from firstlap.ros.trace_reader import TraceReader
from firstlap.sim.race import start_race
from firstlap.sim.race_process import bare, packed
from firstlap.tracks.track import Track

pytest.importorskip("piqp")
pytest.importorskip("gtsam")

CAR = load_car("default")
COARSE = [
    *("line.curvature_rounds=8", "line.time_rounds=4", "line.spacing=0.2", "mpc.stages=20", "time_limit=1"),
    *("map_drive.speed=3", "map_drive.overlap=3", "map_graph.edges=3", "particles_min=300", "particles_max=1000"),
]
"""Fast preparation, and a long time limit so that plans are not late on a busy machine."""
STATUSES = ("ok", "holding", "no_path", "blocked", "bad_scan", "bad_state")


def coarse(*more: str) -> Setup:
    return choose_setup("global", None).with_assignments([*COARSE, *more])


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FIRSTLAP_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def oval() -> Track:
    return firstlap.load_track("oval")


@pytest.fixture(scope="module")
def prepared(oval: Track, cache: None) -> Preparation:
    return prepare(oval)


def prepare(track: Track, *more: str) -> Preparation:
    return driver_kind("global").prepare(track, coarse(*more), CAR, 1, None)


def drive(track, preparation, *more, until=None, change=None, at=1.5, seconds=12.0):
    """Runs a race; returns result, statuses and speeds. change: called with the driver `at` seconds after the start."""
    handle = driver_kind("global").make(coarse(*more).params(CAR.core), CAR, preparation)
    running = start_race(track, handle, CAR, laps=2)
    while running.advance(1) and running.time < seconds:
        if change and running.time >= at:
            change(handle.driver)
            change = None
        if until and until(running):
            break
    result = running.result()
    return result, [STATUSES[status] for status in result["path"]["status"]], result["path"]["speed"]


def stood(result, speeds) -> bool:
    """Asserts that the car was fast, then stopped without contact."""
    return result["contact"] is None and max(speeds) > 2.0 and speeds[-1] < 0.1


def test_the_whole_chain_races_and_counts_its_preparation(cli, monkeypatch, prepared):
    sets = [word for text in COARSE for word in ("--set", text)]
    ran = cli("race", "oval", "--driver", "global", "--laps", 1, *sets, "--json")
    assert ran.code == 0, ran
    before = ran.json["preparation"]
    assert before["driving"] > 5.0
    assert before["computing"] > 0.0
    assert before["seconds"] == pytest.approx(before["driving"] + before["computing"], abs=0.01)
    assert ran.json["laps"][0]["mean_speed"] > 2.5


def test_map_and_line_are_found_again_by_their_content(oval, prepared):
    again = prepare(oval)
    assert again.cached
    assert again.seconds == prepared.seconds
    assert np.array_equal(again.given.line.path.points, prepared.given.line.path.points)
    looks: list[str] = []
    other = driver_kind("global").prepare(oval, coarse("line.margin=0.2"), CAR, 1, lambda what, _: looks.append(what))
    assert not other.cached
    assert "mapping lap" not in looks
    assert any(what.startswith("least") for what in looks)
    assert other.given.line.lap_time > prepared.given.line.lap_time


def test_the_line_is_that_of_the_map_and_begins_where_the_car_stands(oval, prepared):
    line = prepared.given.line
    assert np.hypot(*line.path.points[0]) < 1.5
    assert abs(line.path.heading[0]) < 0.5
    assert abs(prepared.given.walls.length / oval.length - 1.0) < 0.02


def test_reverse_is_driven_the_other_way_round(oval):
    turned = oval.reversed()
    preparation = prepare(turned)
    assert np.sum(preparation.given.line.path.curvature) * np.sum(turned.width) < 0.0
    result, statuses, _ = drive(turned, preparation, seconds=3.0)
    assert result["contact"] is None
    assert result["path"]["s"][-1] > 5.0
    assert statuses[-1] == "ok"


@pytest.mark.parametrize("at", [1.2, 1.8, 2.4])
def test_a_lost_filter_stops_the_car_clear_of_the_walls(oval, prepared, at):
    def lose(driver):
        driver._pose = lambda *_: None

    result, statuses, speeds = drive(oval, prepared, change=lose, at=at, seconds=at + 2.0)
    assert stood(result, speeds)
    assert statuses[-1] == "no_path"


def test_a_car_set_down_elsewhere_stops_or_finds_itself(oval, prepared):
    def kidnap(driver):
        driver.localizer.core.displace(0.3, -0.4, 0.2)

    result, statuses, _ = drive(oval, prepared, change=kidnap, until=lambda race: race.laps_done() == 1)
    assert result["contact"] is None
    assert len(result["laps"]) == 1
    assert statuses[-1] == "ok"


def test_a_car_placed_by_hand_at_the_pit_wall_finds_itself(oval, prepared):
    race = SimRace(Plan(bare(oval), packed(CAR), load_setup("sure"), 1, {}))
    race.set_setup(coarse())
    for share in (0.3, 0.8, 0.55):
        race.place(oval.start_pose(share * oval.length))
        for _ in range(80):
            race.tick()
        assert race.may_drive
        assert "contact" not in race.message
        truth, estimate = race.world.truth(0), race.driving.handle.driver.estimate
        x, y, _ = between(np.array(oval.start_pose()), np.array([truth["x"], truth["y"], truth["yaw"]]))
        assert np.hypot(estimate.x - x, estimate.y - y) < 0.3
        assert truth["speed"] > 2.0
    race.restart()
    while not race.laps:
        race.tick()
    assert race.laps[0].standing
    assert race.laps[0].setup == coarse()


def test_a_driver_of_one_way_is_not_placed_backwards(oval, prepared):
    source = SimSource(oval, coarse(), CAR)
    x, y, yaw = oval.start_pose(5.0)
    with pytest.raises(InputError, match="one direction"):
        source.place((x, y, yaw + np.pi))


@pytest.mark.parametrize("name", ["hairpins", "arena"])
def test_a_map_of_another_track_moves_nobody_into_a_wall(prepared, name):
    result, statuses, speeds = drive(firstlap.load_track(name), prepared, seconds=4.0)
    assert result["contact"] is None
    assert statuses[-1] != "ok"
    assert speeds[-1] < 0.1


def test_a_wall_that_the_map_does_not_know_stops_the_car_before_it(oval, prepared):
    x, y, yaw = oval.start_pose(0.25 * oval.length)
    across = np.array([[-np.sin(yaw), np.cos(yaw)]]) * np.array([[-3.0], [3.0]])
    closed = replace(
        oval,
        walls=[*oval.walls, across + np.array([x, y])],
        sides=[*oval.sides, "obstacle"],
        visible=[*oval.visible, True],
        solid=[*oval.solid, True],
    )
    result, statuses, speeds = drive(closed, prepared, seconds=4.0)
    assert stood(result, speeds)
    assert "blocked" in statuses


def test_a_line_through_a_wall_is_refused(prepared):
    given = prepared.given
    path = given.line.path
    through = replace(given.line, path=replace(path, points=path.points + np.array([3.0, 0.0])))
    bad = replace(prepared, given=replace(given, line=through))
    with pytest.raises(InputError, match="into a wall at s = "):
        driver_kind("global").make(coarse().params(CAR.core), CAR, bad)


def test_a_solver_that_fails_is_survived_along_the_last_plan_then_stopped(oval, prepared):
    def fail(driver):
        driver.controller._solver.solve = lambda: None

    result, statuses, speeds = drive(oval, prepared, change=fail, seconds=3.5)
    assert stood(result, speeds)
    assert "holding" in statuses
    assert statuses[-1] == "no_path"


def test_plans_that_come_late_are_survived_along_the_last_one_then_stopped(oval, prepared):
    def slow(driver):
        ticks = iter(range(10**9))
        driver.controller._clock = lambda: 10.0 * next(ticks)

    result, statuses, speeds = drive(oval, prepared, change=slow, seconds=3.5)
    assert stood(result, speeds)
    assert "holding" in statuses
    assert statuses[-1] == "no_path"


def test_absurd_data_never_raises(prepared):
    driver = driver_kind("global").make(coarse().params(CAR.core), CAR, prepared).driver
    for ranges in (np.full(1081, np.nan), np.full(1081, np.inf), np.zeros(1081), np.zeros(0)):
        for state in ((0.0, 0.0, 0.0), (np.nan, 0.0, 0.0), (1e300, np.inf, -np.inf)):
            for dt in (0.025, 0.0, np.nan):
                speed, steering, status = driver.step(
                    _core.LaserScan(ranges.astype(np.float32)), _core.VehicleState(*state), dt
                )
                assert speed == 0.0
                assert np.isfinite(steering)
                assert status != "ok"


def test_a_survey_races_it_in_processes(oval, prepared):
    survey = Survey(coarse(), CAR, laps=1)
    survey.drive([Run("oval", oval, reverse=False, seed=1)])
    found = survey.to_dict()
    assert (found["driver"], found["finished"]) == ("global", 1)


def test_the_road_of_a_map_ends_at_joints_that_only_the_laser_passes():
    cells = np.full((60, 200), UNKNOWN, dtype=np.uint8)
    cells[10:30, 5:195] = FREE  # the track, 1 m wide
    cells[30, 5:195] = OCCUPIED
    cells[30, 100:106] = FREE  # a joint of 0.3 m
    cells[31:55, 5:195] = FREE  # what is visible through it
    road = road_of(OccupancyMap(cells, 0.05, (0.0, 0.0, 0.0)), np.array([[1.0, 1.0], [9.0, 1.0]])).cells
    assert (road[13:27, 10:190] == FREE).all()
    assert (road[36:] != FREE).all()
    assert (road[cells == OCCUPIED] == OCCUPIED).all()


def test_small_unmet_places_of_a_map_are_free_unless_a_wall_is_near():
    cells = np.zeros((20, 20), dtype=np.uint8)
    cells[5, 5:8] = UNKNOWN
    cells[12, 12], cells[13, 12] = UNKNOWN, OCCUPIED
    cells[16:19, 0:9] = UNKNOWN
    filled = without_gaps(cells, 0.03)
    assert (filled[5, 5:8] == FREE).all()
    assert filled[12, 12] == UNKNOWN
    assert (filled[16:19, 0:9] == UNKNOWN).all()


def test_the_ablation_drives_by_the_true_pose_and_says_so(cli, oval, prepared):
    assert firstlap.race(oval, coarse("true_pose=true"), CAR, laps=1, preparation=prepared).finished
    ran = cli("race", "oval", "--driver", "gap", "--true-pose")
    assert ran.code == 2
    assert "--driver global" in ran.err


def test_explain_draws_a_step(cli, prepared):
    sets = [word for text in COARSE for word in ("--set", text)]
    ran = cli("explain", "oval", "--driver", "global", *sets, "--at", 2)
    assert ran.code == 0, ran


def test_every_array_of_its_trace_is_in_a_table(oval, prepared):
    handle = driver_kind("global").make(coarse().params(CAR.core), CAR, prepared)
    told = TraceHeader("7-1", "global", 12.5, 3.0, 0.1, -0.2, 45.0, True, "")
    race = start_race(oval, handle, CAR, laps=1)
    for steps in (0, 20):
        race.advance(steps)
        types = topics_of("global")
        reader, sent = TraceReader(), messages_of(told, handle.trace, "base_link", (0.27, 0.0), set(types))
        heard = [reader.add(name, typestore().deserialize_cdr(data, types[name])) for name, data in sent]
        _, got = next(step for step in heard if step)
        assert got.keys() == handle.trace.keys()
        np.testing.assert_allclose(got["plan"], handle.trace["plan"], atol=1e-5)
        assert got["result"] == handle.trace["result"]


def test_every_part_keeps_its_defaults():
    from firstlap.control.mpc.params import MpcParams
    from firstlap.drivers.global_driver.params import GlobalParams
    from firstlap.mapping.parameters import map_settings
    from firstlap.planning.raceline.params import LineParams

    parts = GlobalParams().parts()
    assert parts.line == LineParams()
    assert parts.mpc == MpcParams()
    assert parts.mapping.core.values() == map_settings().core.values()
    assert parts.localizer.values() == firstlap._core.LocalizerParams().values()


def test_a_race_may_start_anywhere_on_the_track(oval, prepared):
    result = firstlap.race(oval, coarse(), CAR, laps=1, preparation=prepared, options={"start_s": 0.4 * oval.length})
    assert result.finished
    assert (result.path["status"][8:] == STATUSES.index("ok")).all()


@pytest.mark.parametrize("error", [-0.15, 0.15])
@pytest.mark.parametrize("wrong", ["sensors.speed_scale_error", "vehicle.speed_constant_error"])
def test_a_wrong_speed_is_found_out_on_the_map(oval, prepared, wrong, error):
    result = firstlap.race(oval, coarse(), CAR, laps=2, preparation=prepared, options={wrong: error})
    assert result.finished


def test_a_car_that_is_carried_far_off_stops_and_finds_itself_on_the_whole_map(oval, prepared):
    def carry(driver):
        driver.localizer.core.displace(-6.0, 0.0, 0.0)

    result, statuses, speeds = drive(oval, prepared, change=carry, at=7.5, seconds=20.0)
    assert result["contact"] is None
    assert len(result["laps"]) == 2
    assert statuses[-1] == "ok"
    stop = int(np.argmin(speeds[200:])) + 200
    assert speeds[stop] < 0.1 < max(speeds[stop:])


def test_a_car_that_fits_nowhere_seeks_itself_so_many_times_and_stays(prepared):
    from firstlap.drivers.global_driver.params import GuardParams
    from firstlap.drivers.global_driver.relocalization import Relocalization

    path = prepared.given.line.path
    sought = Relocalization(GuardParams(search_after=0.0), prepared.given.known.field(), path.points, path.heading)
    ring = 9.0 * np.column_stack([np.cos(np.arange(90.0)), np.sin(np.arange(90.0))])
    assert all(sought.look(ring, 0.0, 0.025) is None for _ in range(200))
    assert sought._rounds == GuardParams().searches
    sought.rest()
    walls, at = prepared.given.known.wall_points(), path.poses[40]
    turn = np.array([[np.cos(at[2]), -np.sin(at[2])], [np.sin(at[2]), np.cos(at[2])]])
    near = (walls - at[:2]) @ turn
    near = near[np.hypot(*near.T) < 8.0]
    found = [pose for _ in range(30) if (pose := sought.look(near, 0.0, 0.025))]
    assert np.hypot(found[0][0] - at[0], found[0][1] - at[1]) < 0.1


@pytest.mark.parametrize("place", [0.53, 0.55])
def test_it_stops_for_an_obstacle_that_appears_at_its_stopping_distance(oval, prepared, place):
    from firstlap.evaluation.robustness.cases import stopping_distance

    options = {"obstacle_at": place * oval.length, "obstacle_width": 1.4, "stuck_time": 0.5, "obstacle_sight": 5.0}
    result = firstlap.race(oval, coarse(), CAR, laps=1, preparation=prepared, options=options)
    seen = result.obstacle
    assert 1.25 * stopping_distance(CAR, seen.speed, abs(seen.speed * seen.yaw_rate)) < 5.0
    assert seen.speed > 4.0
    assert result.contact is None
    assert result.outcome == "stuck"


def test_nothing_thin_is_missed_between_two_places_that_are_looked_at(prepared):
    from firstlap.control.mpc.model import model_of
    from firstlap.drivers.global_driver.guard import Guard

    parts = coarse("blocked_scans=1").params(CAR.core).parts()
    guard = Guard(parts.guard, CAR, model_of(CAR))
    from firstlap.drivers.global_driver.guard import EVERY

    way = np.column_stack([np.arange(0.0, 8.0, EVERY), *np.zeros((2, round(8.0 / EVERY)))])
    for ahead in np.linspace(1.0, 7.0, 61):
        thin = np.array([[ahead, -0.03], [ahead, 0.0], [ahead, 0.03]])
        found = guard.look(way, thin)
        assert found == pytest.approx(ahead - guard.body.front + parts.guard.shrink, abs=1e-9), ahead
