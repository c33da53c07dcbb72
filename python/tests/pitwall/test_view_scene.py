"""The pit wall's drawings: content of the scene, bounded memory, plots and tables."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

import viser
from racing import Racing, scenery_of, some_lap
from shapely import MultiLineString, Point
from viewing import Viewer, served, wait_until

import firstlap
from firstlap.config.car_file import load_car
from firstlap.pitwall.app import App
from firstlap.pitwall.authentication import Authenticator
from firstlap.pitwall.camera import FOLLOW, FREE, TURN, Viewpoint
from firstlap.pitwall.frame import DrivenLap, Frame, Scenery
from firstlap.pitwall.lap_table import LapTable, table_of
from firstlap.pitwall.layers import LAYERS, MIDDLE, RETURNS
from firstlap.pitwall.map_shapes import best_of
from firstlap.pitwall.opponents import draw
from firstlap.pitwall.plots import PLOTS, SECONDS, STEPS, History, Plots, _so_far, drawable, head_of
from firstlap.pitwall.primitives import placed
from firstlap.pitwall.scene import Scene, commanded
from firstlap.pitwall.shapes import compose, inverse
from firstlap.pitwall.status import scale_of, status_of

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
GEOMETRY = load_car("default").core.values()["geometry"]
DRIVERS = ("local", "gap", "disparity", "pid")


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    """One server for all tests."""
    with served(Authenticator()) as opened:
        yield opened


@pytest.fixture(scope="module")
def frames(arena: firstlap.Track) -> dict[str, Frame]:
    """A frame of each driver after two seconds of driving."""
    return {name: driven(arena, name, 80) for name in DRIVERS}


@pytest.fixture
def scene(server: viser.ViserServer, arena: firstlap.Track) -> Scene:
    """The scenery of arena."""
    server.scene.reset()
    return Scene(server, scenery_of(arena), load_car("default"))


def driven(track: firstlap.Track, driver: str, steps: int) -> Frame:
    race = Racing(track, driver)
    return [race.step() for _ in range(steps)][-1]


def shown(server: viser.ViserServer, name: str) -> Any:
    """The object of that name, if it is visible."""
    handle = server.scene.get_handle_by_name(name)
    assert handle is not None, name
    return handle if handle.visible else None


def nodes(server: viser.ViserServer) -> set[str]:
    return set(server.scene._handle_from_node_name)


def buffered(server: viser.ViserServer) -> int:
    return len(server._websock_server._broadcast_buffer.message_from_id)


# The scene.


def test_the_scan_is_drawn_by_side_where_it_was_seen(
    scene: Scene, server: Any, frames: dict[str, Frame], arena: firstlap.Track
) -> None:
    frame = frames["local"]
    scene.show(frame)
    drawn = [shown(server, f"/map/returns/{side}") for side in ("left", "right")]
    counts = [len(np.unique(cloud.points, axis=0)) for cloud in drawn]
    assert min(counts) > 50
    assert sum(counts) <= len(frame.trace["points"])
    walls = MultiLineString([wall for wall, seen in zip(arena.walls, arena.visible, strict=True) if seen])
    for cloud in drawn:
        away = [walls.distance(Point(point[:2])) for point in cloud.points]
        assert np.median(away) < 0.05


def test_the_path_has_the_colors_of_its_speeds(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    scene.show(frames["local"])
    path = shown(server, "/map/path/path")
    assert path.points.shape == path.colors.shape
    assert len(np.unique(path.colors.reshape(-1, 3), axis=0)) > 3
    assert scene.top >= frames["local"].trace["path"]["velocity"].max()


def test_what_the_loaded_setup_would_do_is_drawn_beside_it(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    scene.show(frames["local"])
    assert shown(server, "/map/before/path") is None
    for name in ("local", "gap"):
        scene.show(replace(frames[name], before=frames[name].trace))
        assert shown(server, "/map/before/path")


def test_the_car_stands_at_its_pose_with_its_wheels_turned(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    frame = replace(frames["local"], pose=(1.0, 2.0, 0.5), steering_angle=0.3)
    scene.show(frame)
    rear, half = -GEOMETRY["rear_overhang"], 0.5 * GEOMETRY["width"]
    chassis = placed(inverse(frame.pose), shown(server, "/map/body/chassis").vertices)
    assert chassis.min(axis=0)[:2] == pytest.approx((rear, -half), abs=1e-5)
    assert chassis.max(axis=0)[:2] == pytest.approx((rear + GEOMETRY["length"], half), abs=1e-5)
    wheel, arrow = (shown(server, f"/map/body/{name}").vertices for name in ("front_left", "command"))
    assert heading(wheel[1] - wheel[0]) == pytest.approx(0.5 + 0.3)
    assert heading(arrow[5] - 0.5 * (arrow[0] + arrow[3])) == pytest.approx(0.5 + frame.trace["result"][1], abs=1e-5)


def heading(vector: np.ndarray) -> float:
    """[rad]"""
    return math.atan2(vector[1], vector[0])


def test_nothing_that_changes_with_the_car_has_a_pose_of_its_own(
    scene: Scene, server: Any, frames: dict[str, Frame]
) -> None:
    """A browser renders new poses one frame before new points."""
    for name, frame in frames.items():
        for pose in ((1.0, 2.0, 0.5), (2.0, 1.0, -0.5)):
            scene.show(replace(frame, pose=pose, steering_angle=pose[2]))
            for node in nodes(server):
                handle = server.scene.get_handle_by_name(node)
                assert (tuple(handle.position), tuple(handle.wxyz)) == ((0, 0, 0), (1, 0, 0, 0)), (name, node)


def test_a_car_whose_place_is_not_known_stands_at_the_origin(
    scene: Scene, server: Any, frames: dict[str, Frame]
) -> None:
    frame = replace(frames["local"], pose=None)
    scene.show(frame)
    assert scene.pose == (0.0, 0.0, 0.0)
    assert np.abs(shown(server, "/map/body/chassis").vertices).max() < GEOMETRY["length"]
    seen = np.vstack([shown(server, f"/map/returns/{side}").points for side in ("left", "right")])
    assert np.abs(seen[:, :2]).max() <= np.abs(frame.trace["points"]).max() + 1e-5


@pytest.mark.parametrize("driver", DRIVERS)
def test_every_driver_is_drawn_and_leaves_nothing_of_the_one_before(
    driver: str, scene: Scene, server: Any, frames: dict[str, Frame]
) -> None:
    for name in (*DRIVERS, driver):
        scene.show(frames[name])
    assert (shown(server, "/map/path/path") is not None) == (driver == "local")
    assert (shown(server, "/map/returns/all") is not None) == (driver != "local")
    assert (shown(server, "/map/aim/free") is not None) == (driver in ("gap", "disparity"))
    assert (shown(server, "/map/aim/ray") is not None) == (driver != "local")
    assert (shown(server, "/map/aim/left") is not None) == (driver == "pid")


def test_the_plan_of_the_map_based_driver_is_drawn(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    poses = np.column_stack([np.linspace(0.0, 4.0, 30), np.zeros(30), np.zeros(30)])
    trace = {
        "result": (3.0, 0.1, "ok"),
        "ranges": np.full(100, 2.0, np.float32),
        "first_beam": -1.0,
        "beam_step": 0.02,
        "map": np.ones((40, 2)),
        "line": poses[:, :2],
        "plan": poses,
        "plan_speed": np.linspace(2.0, 7.2, 30),
        "estimate": {"std": 0.05},
    }
    scene.show(replace(frames["local"], driver="global", trace=trace))
    for name in ("path/plan", "path/outlines", "line/racing", "known/walls", "returns/all", "aim/spread"):
        assert shown(server, f"/map/{name}"), name
    assert scene.top == 8.0


EMPTY_TRACES: list[dict[str, Any]] = [
    {},
    {"result": (0.0, 0.0, "bad_scan")},
    {"points": np.zeros((0, 2)), "sections": {"first": np.zeros(0)}, "path": {"s": np.zeros(0)}, "ranges": np.zeros(0)},
    {"points": None, "left": None, "line": {"points": np.zeros((3, 2))}, "path": {"x": np.ones(3)}, "free": np.ones(1)},
    {"left": {"points": np.full((4, 2), np.nan), "age": np.ones(4)}, "plan": np.zeros((1, 3)), "aim": math.nan},
]


@pytest.mark.parametrize("driver", [*DRIVERS, "global", "one of somebody else's"])
@pytest.mark.parametrize("trace", EMPTY_TRACES)
def test_a_trace_that_lacks_something_is_drawn_without_it(
    driver: str, trace: dict[str, Any], scene: Scene, server: Any, frames: dict[str, Frame]
) -> None:
    scene.show(frames["local"])
    frame = replace(frames["local"], driver=driver, trace=trace)
    scene.show(frame)
    assert shown(server, "/map/path/path") is None
    assert shown(server, "/map/returns/left") is None
    for plot in PLOTS:
        head_of(plot, frame)
    status_of(frame, "base", 30.0)


def test_a_driver_that_nobody_knows_has_its_returns_drawn() -> None:
    trace = {"ranges": np.array([1.0, math.inf, 2.0, 0.0]), "first_beam": 0.0, "beam_step": 0.1}
    assert len(draw("new", trace, GEOMETRY).returns) == 2


def test_the_gap_that_is_drawn_is_the_one_that_was_chosen(frames: dict[str, Frame]) -> None:
    trace = frames["gap"].trace
    chosen = draw("gap", trace, GEOMETRY).chosen - (GEOMETRY["laser_x"], 0.0)
    angles = np.arctan2(chosen[:, 1], chosen[:, 0])
    assert angles.min() == pytest.approx(trace["run"][0], abs=0.02)
    assert angles.max() == pytest.approx(trace["run"][1], abs=0.02)


def test_walls_that_the_lidar_does_not_see_are_dashed(server: viser.ViserServer) -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]])
    server.scene.reset()
    Scene(server, Scenery((square, square + 1.0), (True, False), square[:-1]), load_car("default"))
    seen, unseen = shown(server, "/map/walls/seen"), shown(server, "/map/walls/unseen")
    assert len(seen.points) == 4
    assert len(unseen.points) > 40
    assert np.hypot(*(unseen.points[:, 1] - unseen.points[:, 0])[:, :2].T).max() < 0.2


def test_without_a_track_there_is_ground_to_drive_on(server: viser.ViserServer, frames: dict[str, Frame]) -> None:
    server.scene.reset()
    scene = Scene(server, Scenery(), load_car("default"))
    scene.show(replace(frames["local"], pose=None))
    ground = shown(server, "/map/ground/meters")
    assert shown(server, "/map/walls/seen") is None
    scene.show(replace(frames["local"], pose=(100.0, -30.0, 0.0)))
    low, high = ground.points[..., :2].min(axis=(0, 1)), ground.points[..., :2].max(axis=(0, 1))
    assert (low + ground.position[:2] < [85.0, -45.0]).all()
    assert (high + ground.position[:2] > [115.0, -15.0]).all()


# Laps.


def test_the_best_lap_is_marked_also_when_it_is_an_old_one(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    times = [12.0, 9.0, 10.0, 11.0, 10.5, 10.2, 10.4, 10.1]
    laps = tuple(
        DrivenLap(i + 1, time, np.array([[i, 0.0], [i, 1.0]], float), np.ones(2), 0.2, i == 0)
        for i, time in enumerate(times)
    )
    scene.show(replace(frames["local"], laps=laps))
    assert shown(server, "/map/laps/best").points[0, 0, 0] == 1.0
    assert [shown(server, f"/map/laps/{i}").points[0, 0, 0] for i in range(5)] == [7.0, 6.0, 5.0, 4.0, 3.0]
    scene.show(replace(frames["local"], laps=()))
    assert shown(server, "/map/laps/best") is None


def test_a_lap_from_rest_is_the_best_only_while_there_is_no_other() -> None:
    first, second = some_lap(1, 9.0, standing=True), some_lap(2, 9.5)
    assert best_of((first,)) is first
    assert best_of((first, second)) is second
    assert best_of(()) is None


def test_the_table_says_what_each_lap_lacks_to_the_best() -> None:
    text = table_of((some_lap(1, 9.0, standing=True), some_lap(2, 8.75), some_lap(3, 8.5)), 1.25)
    assert text.index("running") < text.index("8.500") < text.index("8.750") < text.index("9.000")
    assert "+0.250" in text
    assert "+0.500" in text
    assert text.count(">best<") == 1
    assert "0.30" in text


def test_a_best_lap_that_is_long_ago_stays_in_the_table() -> None:
    laps = (some_lap(1, 5.0), *(some_lap(i, 9.0) for i in range(2, 40)))
    assert "5.000" in table_of(laps, None)
    assert len(table_of(laps, None)) < 8000


def test_the_running_lap_is_timed_only_where_it_was_seen_to_begin(
    server: viser.ViserServer, frames: dict[str, Frame]
) -> None:
    table, late = LapTable(server.gui), replace(frames["local"], time=70.0)
    table.show(late)
    assert "–</td>" in table._html.content
    table.show(replace(late, time=71.0, laps=(some_lap(1, 9.0),)))
    table.show(replace(late, time=73.5, laps=(some_lap(1, 9.0),)))
    assert "2.5</td>" in table._html.content


def test_the_running_lap_is_timed_from_where_its_source_says(
    server: viser.ViserServer, frames: dict[str, Frame]
) -> None:
    table, now = LapTable(server.gui), replace(frames["local"], time=0.5)
    table.show(now)
    table.show(replace(now, time=7.5, lap_start=6.25))  # restarted before its first lap was done
    assert "1.2</td>" in table._html.content


# Bounded memory.


def test_nothing_grows_over_200_frames(scene: Scene, server: Any, arena: firstlap.Track) -> None:
    race, plots = Racing(arena), Plots(server.gui)
    scene.show(race.step())
    for _ in range(40):
        frame = race.step()
        scene.show(frame)
        plots.add(frame)
    plots.draw(frame)
    names, messages = nodes(server), buffered(server)
    for i in range(200):
        frame = replace(race.step(), laps=tuple(some_lap(n, 9.0) for n in range(i // 20)))
        scene.show(frame)
        plots.add(frame)
        if i % 4 == 0:
            plots.draw(frame)
    assert nodes(server) == names
    assert buffered(server) <= messages + len(names)  # only objects that were not shown before may be shown or hidden
    assert all(tuple(map(len, chart.data)) == (STEPS,) * len(chart.data) for chart in plots._charts)


# Plots.


def test_plots_keep_the_last_ten_seconds(frames: dict[str, Frame]) -> None:
    history = History()
    for i in range(1200):
        history.add(replace(frames["local"], time=0.025 * i, speed=float(i)))
    ago, values = history.sampled()
    speed = values[:, 2]
    assert (ago[0], ago[-1]) == (-SECONDS, 0.0)
    assert speed[-1] == 1199.0
    assert speed[0] == pytest.approx(1199.0 - SECONDS / 0.025, abs=1.0)


def test_plots_show_nothing_for_the_time_before_there_was_anything(frames: dict[str, Frame]) -> None:
    history = History()
    assert np.isnan(history.sampled()[1]).all()
    for time in (50.0, 51.0):
        history.add(replace(frames["local"], time=time, speed=2.0))
    speed = history.sampled()[1][:, 2]
    assert np.isfinite(speed).sum() == 1 + (STEPS - 1) // int(SECONDS)
    history.add(replace(frames["local"], time=3.0))  # the recording was rewound
    assert np.isfinite(history.sampled()[1][:, 2]).sum() == 1


def test_a_plot_is_given_numbers_only() -> None:
    ago, nothing = np.linspace(-SECONDS, 0.0, STEPS), np.full((STEPS, 3), np.nan)
    assert all(np.isfinite(column).all() for column in drawable(ago, nothing))
    late = nothing.copy()
    late[150:, 0] = np.arange(STEPS - 150)
    late[160:170, 0] = np.nan
    seconds, first, second, third = drawable(ago, late)
    assert seconds[0] == seconds[150] == ago[150]
    assert seconds[-1] == 0.0
    assert (first[:151] == 0.0).all()
    assert (first[160:170] == 9.0).all()
    assert (second == first).all()
    assert (third == first).all()


def test_a_curve_without_values_hides_none_that_has_some() -> None:
    for plot in PLOTS:
        assert "" in plot.curves[-1].names, plot.title
        assert plot.curves[-1].value is not _so_far  # recordings do not have it


def test_the_terms_of_the_steering_are_plotted_in_degrees(frames: dict[str, Frame]) -> None:
    trace = frames["local"].trace["steering"]
    values = [curve.value(frames["local"]) for curve in PLOTS[1].curves[:5]]
    names = ("heading", "cross_track", "yaw_rate", "steering", "steering_angle")
    assert values == pytest.approx([math.degrees(trace[name]) for name in names])
    assert values[4] == pytest.approx(sum(values[:4]))


def test_names_and_words_of_others_cannot_become_markup(frames: dict[str, Frame]) -> None:
    frame = replace(frames["local"], driver="<b>x", message="<script>alert(1)</script>")
    text = status_of(frame, "<i>setup", 25.0)
    for told in ("<b>x", "<script>", "<i>setup"):
        assert told not in text


def test_the_scale_names_its_ends() -> None:
    assert ">0<" in scale_of(6.0)
    assert ">6<" in scale_of(6.0)


# Viewers.


def test_compose_and_inverse_undo_each_other() -> None:
    a, b = (1.0, -2.0, 0.7), (0.3, 4.0, -1.9)
    assert compose(inverse(a), compose(a, b)) == pytest.approx(b)


@pytest.fixture(scope="module")
def wall(arena: firstlap.Track) -> Iterator[tuple[App, Authenticator]]:
    """A complete pit wall with a race."""
    source, authenticator = Racing(arena), Authenticator()
    server = authenticator.open(port=0)
    app = App(source, server, authenticator, None)
    source.start()
    yield app, authenticator
    app.close()
    source.close()


def test_frames_reach_every_viewer_and_none_has_what_another_hides(wall: tuple[App, Authenticator]) -> None:
    app, authenticator = wall
    viewers = [Viewer(authenticator).enter() for _ in range(2)]
    wait_until(lambda: app.viewers == 2)
    one, other = (app._viewpoints[key] for key in sorted(app._viewpoints))
    one.hide(RETURNS, True)
    assert not one._layers[RETURNS.node].visible
    assert other._layers[RETURNS.node].visible
    assert not other._layers[MIDDLE.node].visible
    wait_until(lambda: app.updates > 10.0)
    for viewer in viewers:
        heard = [message for message in viewer.heard(0.5) if message.get("name") == "/map/returns/left"]
        assert heard
        viewer.close()
    wait_until(lambda: app.viewers == 0)


def test_a_click_means_the_place_on_the_map_in_every_mode(wall: tuple[App, Authenticator]) -> None:
    app, authenticator = wall
    viewer = Viewer(authenticator).enter()
    wait_until(lambda: app.viewers == 1)
    (client,) = app._server.get_clients().values()
    point, pose = Viewpoint(client, Scenery()), (3.0, 1.0, math.pi / 2)
    point.show(pose)
    down = (0.0, 0.0, -1.0)
    assert point.mode == TURN
    assert point.on_map((1.0, 0.0, 9.0), down) == pytest.approx((3.0, 2.0))  # a meter ahead of the car
    point.choose(FOLLOW)
    assert point.on_map((1.0, 0.0, 9.0), down) == pytest.approx((4.0, 1.0))  # a meter east of it
    point.choose(FREE)
    assert point.on_map((1.0, 0.0, 9.0), down) == pytest.approx((1.0, 0.0))
    assert client.camera.position[:2] == pytest.approx((3.0, 1.0), abs=0.01)  # the center of the view is unchanged
    point.overview()
    assert point.on_map((0.0, 0.0, 9.0), (0.0, 0.0, 1.0)) is None
    viewer.close()


def test_a_frame_that_cannot_be_shown_is_said_once_and_the_next_one_is_shown(
    wall: tuple[App, Authenticator], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    app, _ = wall
    output: list[str] = []

    def broken(_frame: Frame) -> None:
        output.append("")
        raise ValueError("no good\nframe")

    monkeypatch.setattr(app.scene, "show", broken)
    wait_until(lambda: len(output) > 3)
    monkeypatch.undo()
    before = len(app._frame_times), app._frame_times[-1] if app._frame_times else 0.0
    wait_until(lambda: bool(app._frame_times) and app._frame_times[-1] > before[1])
    assert capsys.readouterr().err.count("view: ValueError: no good frame") == 1


def test_a_closed_pit_wall_leaves_no_thread_and_says_nothing(
    arena: firstlap.Track, capfd: pytest.CaptureFixture[str]
) -> None:
    before = set(threading.enumerate())
    authenticator = Authenticator()
    app = App(Racing(arena), authenticator.open(port=0), authenticator, None)
    viewer = Viewer(authenticator).enter()
    wait_until(lambda: app.viewers == 1)
    app.close()
    app.close()
    viewer.close()
    wait_until(lambda: set(threading.enumerate()) <= before)
    ran = capfd.readouterr()
    assert ran.out == ""
    assert ran.err == ""


def test_every_layer_has_a_node_and_a_word_of_explanation(scene: Scene, server: Any) -> None:
    assert {layer.node for layer in LAYERS} <= nodes(server)
    assert all(layer.doc and layer.title for layer in LAYERS)


def test_the_lookahead_ring_is_where_the_trace_has_it(scene: Scene, server: Any, frames: dict[str, Frame]) -> None:
    frame = frames["local"]
    name = next(node for node in nodes(server) if node.endswith("/lookahead"))
    at = frame.trace["lookahead"]
    for pose in (frame.pose, (1.0, -2.0, 0.7)):
        scene.show(replace(frame, pose=pose))
        ring = shown(server, name).vertices[:64]
        assert pose is not None
        assert ring.mean(axis=0)[:2] == pytest.approx(compose(pose, (at["x"], at["y"], 0.0))[:2], abs=1e-3)
    scene.show(replace(frame, trace={}))
    assert shown(server, name) is None


def test_what_the_car_is_sent_is_shown_rather_than_the_wish_of_the_driver(frames: dict[str, Frame]) -> None:
    frame = frames["local"]
    wish = frame.trace["result"][0]
    assert wish > 1.0 and commanded(frame)[0] == wish
    stopped = replace(frame, may_drive=False, message="emergency stop", sent=(0.0, 0.1))
    assert commanded(stopped)[:2] == (0.0, 0.1)
    assert "of 0.0" in status_of(stopped, "setup sure", 30.0)
    (curve,) = [curve for curve in PLOTS[0].curves if curve.name("local") == "commanded"]
    assert curve.value(stopped) == 0.0
