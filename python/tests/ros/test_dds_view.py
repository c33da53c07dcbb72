"""The pit wall's ROS source over DDS: watches and changes a driving node in a separate process."""

from __future__ import annotations

import re
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
import shapely
from lifecycle_msgs.msg import Transition

import firstlap
from firstlap.common.errors import InputError
from firstlap.pitwall.frame import Frame
from firstlap.pitwall.ros_source import RosSource
from firstlap.pitwall.source import Drives

pytestmark = pytest.mark.dds


@pytest.fixture(scope="module")
def watched(lapping_lab: Any) -> Iterator[RosSource]:
    """A source for the driving car."""
    source = RosSource(domain=lapping_lab.domain)
    source.start()
    yield source
    source.close()


def frame_when(lab: Any, source: RosSource, holds: Callable[[Frame], Any], what: str) -> Frame:
    """Waits for the first new frame that satisfies the condition."""
    before = source.latest()
    seen: list[Frame] = []

    def found() -> bool:
        frame = source.latest()
        if frame is not None and frame is not before and holds(frame):
            seen.append(frame)
        return bool(seen)

    lab.until(found, what)
    return seen[0]


def drives(lab: Any, source: RosSource) -> Frame:
    """Waits until the car drives, by the source's consent."""

    def going(frame: Frame) -> bool:
        if not frame.may_drive:
            with suppress(InputError):
                source.go()
        return bool(frame.may_drive and "path" in frame.trace and frame.speed > 0.5)

    return frame_when(lab, source, going, "a frame of a car that drives")


def test_frames_show_the_path_the_pose_and_the_walls_of_the_car_that_laps(shared_lab: Any, watched: RosSource) -> None:
    assert isinstance(watched, Drives)
    frame = drives(shared_lab, watched)
    assert frame.driver == "local"
    assert len(frame.trace["path"]["x"]) > 10
    assert frame.trace["points"].shape[1] == 2
    assert frame.step_us > 0.0
    assert frame.clearance is not None
    assert 0.0 < frame.clearance < 2.0
    frame = frame_when(shared_lab, watched, lambda one: one.pose, "a pose")
    shared_lab.until(lambda: watched.scenery.walls, "walls of the map")
    low, high = watched.scenery.bounds() or (np.zeros(2), np.zeros(2))
    walls = np.asarray(firstlap.load_track("arena").to_arrays()["segments"]).reshape(-1, 2)
    np.testing.assert_allclose(low, walls.min(axis=0), atol=0.1)
    np.testing.assert_allclose(high, walls.max(axis=0), atol=0.1)
    assert frame.pose is not None
    assert (low < frame.pose[:2]).all()
    assert (high > frame.pose[:2]).all()
    x, y, yaw = frame.pose
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    seen = frame.trace["points"] @ turn + [x, y]
    walls_there = shapely.MultiLineString(watched.scenery.walls)
    beside = np.median([walls_there.distance(shapely.Point(point)) for point in seen[::20]])
    assert beside < 0.15, "what it sees lies along the walls of the map"


def test_a_parameter_arrives_in_the_node_and_a_change_by_others_is_seen(shared_lab: Any, watched: RosSource) -> None:
    from rcl_interfaces.srv import GetParameters

    before = watched.loaded.get("v_max")
    watched.change({"velocity_profile.v_max": 4.0, "stanley.k_dist": 1.1})
    assert (watched.setup.get("v_max"), watched.loaded.get("v_max")) == (4.0, before)
    request = GetParameters.Request(names=["velocity_profile.v_max", "stanley.k_dist"])
    values = shared_lab.probe.call(GetParameters, "/firstlap_drive/get_parameters", request).values
    assert [value.double_value for value in values] == [4.0, 1.1]
    assert shared_lab.probe.set("/firstlap_drive", velocity_profile__v_max=4.5) == [""]
    shared_lab.until(lambda: watched.setup.get("v_max") == 4.5, "the change of somebody else")


def test_a_bad_value_is_refused_with_the_nodes_reason_and_nothing_changes(shared_lab: Any, watched: RosSource) -> None:
    setup = watched.setup
    for wrong, reason in (
        ({"velocity_profile.v_max": 1.0}, "v_min"),
        ({"velocity_profile.v_max": 99.0}, "out of range"),
        ({"stanley.k_dist": 1.0, "velocity_profile.v_max": 1.0}, "v_min"),
        ({"nonsense": 1.0}, "unknown parameter"),
        ({"v_max": float("nan")}, "v_max"),
    ):
        with pytest.raises(InputError, match=reason):
            watched.change(wrong)
        assert watched.setup == setup
    assert shared_lab.probe.set("/firstlap_drive", stanley__k_dist=1.2) == [""], "the node is well"


def test_a_whole_setup_is_chosen_and_one_of_another_driver_says_how(watched: RosSource) -> None:
    watched.choose(firstlap.load_setup("base"))
    assert watched.setup == watched.loaded == firstlap.load_setup("base")
    with pytest.raises(InputError, match="firstlap drive --driver gap"):
        watched.choose(firstlap.load_setup("gap"))
    watched.choose(firstlap.load_setup("sure"))


def test_stop_stops_the_car_within_the_limit_and_only_go_lets_it_drive(shared_lab: Any, watched: RosSource) -> None:
    lab = shared_lab
    drives(lab, watched)
    lab.stops_in_time(watched.stop, known=True)
    frame = frame_when(lab, watched, lambda one: not one.may_drive, "a frame of the stop")
    assert "emergency stop" in frame.message or "~/stop" in frame.message
    answer = lab.probe.trigger("/firstlap_drive/resume")
    assert (answer.success, answer.message) == (False, "emergency stop"), (
        "nobody else's consent counts while it is held"
    )
    drives(lab, watched)


def test_a_lap_is_counted_by_the_cars_pose(shared_lab: Any, watched: RosSource) -> None:
    def lapped(frame: Frame) -> bool:
        if not frame.may_drive:
            drives(shared_lab, watched)
        return bool(frame.laps)

    (lap, *_) = frame_when(shared_lab, watched, lapped, "a lap").laps
    steps = np.hypot(*np.diff(lap.line, axis=0).T)
    assert steps.sum() == pytest.approx(firstlap.load_track("arena").length, rel=0.1)
    assert lap.time > 5.0
    assert lap.clearance is not None
    assert lap.clearance > 0.1


def refused(source: RosSource) -> str:
    """Why consent is refused; empty if it is not."""
    try:
        source.go()
    except InputError as error:
        return str(error)
    return ""


def test_a_node_that_is_not_active_says_so_and_go_lets_it_drive_or_says_why_not(
    shared_lab: Any, watched: RosSource
) -> None:
    lab = shared_lab
    assert lab.probe.change_state(Transition.TRANSITION_DEACTIVATE)
    frame = frame_when(lab, watched, lambda one: "not active" in one.message and one.trace, "the reason, and the scan")
    assert not frame.may_drive
    assert len(frame.trace["points"]) > 500
    assert lab.probe.set("/firstlap_sim", drop_scans=1.0) == [""]
    lab.until(lambda: "no scan" in refused(watched), "go says what is missing")
    assert lab.probe.set("/firstlap_sim", drop_scans=0.0) == [""]
    drives(lab, watched)


def test_a_driver_that_dies_is_said_and_the_scan_shown_and_a_new_one_is_found(
    shared_lab: Any, watched: RosSource
) -> None:
    lab = shared_lab
    drives(lab, watched)
    lab.drive.send(signal.SIGKILL)
    frame = frame_when(lab, watched, lambda one: "no trace for" in one.message and one.trace, "the loss, and the scan")
    assert (frame.driver, set(frame.trace)) == ("", {"points"})
    with pytest.raises(InputError, match=r"no driving node|did not respond"):
        watched.change({"v_max": 3.0})
    lab.start_drive("--setup", "base")
    drives(lab, watched)
    lab.until(lambda: watched.setup.name == "base", "the new node's setup")
    assert watched.loaded == watched.setup


def test_a_held_stop_keeps_a_node_from_driving_that_starts_only_then(shared_lab: Any, watched: RosSource) -> None:
    lab = shared_lab
    watched.stop()
    lab.drive.send(signal.SIGTERM)
    lab.drive.wait()
    lab.start_drive()
    lab.until(lambda: "waiting: an emergency stop was pressed" in lab.drive.output, "a node that waits")
    assert lab.probe.speed() == 0.0
    frame_when(lab, watched, lambda one: not one.may_drive and "active" in one.message, "its frame")
    drives(lab, watched)


def test_a_simulator_that_dies_is_said_and_found_again(shared_lab: Any, watched: RosSource) -> None:
    lab = shared_lab
    lab.sim.send(signal.SIGKILL)
    frame = frame_when(lab, watched, lambda one: not one.may_drive, "the stop")
    assert re.search("no scan for|no odom for", frame.message)
    lab.sim.wait()
    lab.start_sim()
    drives(lab, watched)


def test_where_nobody_is_that_is_said_and_closing_leaves_nothing_running(lab: Any) -> None:
    before = threading.active_count()
    source = RosSource(domain=lab.domain, patience=0.3)
    source.start()
    try:
        frame = frame_when(lab, source, lambda one: True, "a frame")
        assert re.fullmatch(r"no trace for [\d.]+ s: no driving node /firstlap_drive; no scan", frame.message)
        with pytest.raises(InputError, match="no driving node"):
            source.change({"v_max": 3.0})
        source.stop()
        frame_when(
            lab, source, lambda one: "nobody receives the emergency stop" in one.message, "that the stop is not heard"
        )
        with pytest.raises(InputError, match="no driving node"):
            source.go()
    finally:
        source.close()
    assert threading.active_count() == before
