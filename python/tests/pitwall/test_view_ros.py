"""Handling of messages by the pit wall, without ROS: traces, poses, walls of a map."""

from __future__ import annotations

import math
import time
from array import array
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from firstlap.config.car_file import load_car
from firstlap.pitwall.places import Places, clearance, points_of
from firstlap.pitwall.ros_source import MAP_TOPIC, RosSource
from firstlap.ros.map_walls import walls_of


def odometry(stamp: float, x: float, yaw: float, frame: str, speed: float = 1.0) -> Any:
    """A message like nav_msgs/Odometry."""
    turn = SimpleNamespace(x=0.0, y=0.0, z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    whole = math.floor(stamp)
    return SimpleNamespace(
        header=SimpleNamespace(stamp=SimpleNamespace(sec=whole, nanosec=round((stamp - whole) * 1e9)), frame_id=frame),
        pose=SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=x, y=0.0, z=0.0), orientation=turn)),
        twist=SimpleNamespace(
            twist=SimpleNamespace(linear=SimpleNamespace(x=speed, y=0.0), angular=SimpleNamespace(z=0.0))
        ),
    )


def test_a_pose_is_the_one_of_its_moment_across_the_turn_of_an_angle() -> None:
    places = Places()
    assert places.at(1.0) is None
    places.on_odometry(odometry(1.0, 0.0, math.pi - 0.1, "odom"))
    places.on_odometry(odometry(2.0, 4.0, -math.pi + 0.1, "odom"))
    x, _, yaw = places.at(1.75) or (0.0, 0.0, 0.0)
    assert x == pytest.approx(3.0)
    assert math.remainder(yaw - (math.pi + 0.05), 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert places.at(9.0) == places.newest()[1]


def test_a_localizer_puts_the_car_into_the_map_and_laps_begin_anew() -> None:
    places = Places()
    places.on_odometry(odometry(1.0, 2.0, 0.0, "odom"))
    assert not places.in_map
    book = places.book
    turn = SimpleNamespace(x=0.0, y=0.0, z=math.sin(0.25 * math.pi), w=math.cos(0.25 * math.pi))
    place = SimpleNamespace(translation=SimpleNamespace(x=10.0, y=0.0, z=0.0), rotation=turn)
    step = SimpleNamespace(header=SimpleNamespace(frame_id="map"), child_frame_id="odom", transform=place)
    places.frames.add(SimpleNamespace(transforms=[step]))
    places.on_odometry(odometry(1.1, 2.0, 0.0, "odom"))
    assert places.in_map
    assert places.book is not book
    assert places.newest()[1] == pytest.approx((10.0, 2.0, 0.5 * math.pi))


def test_a_simulators_truth_comes_before_odometry() -> None:
    places = Places()
    places.on_ground_truth(odometry(1.0, 7.0, 0.0, "map"))
    places.on_odometry(odometry(1.1, 2.0, 0.0, "odom", speed=3.0))
    assert (places.in_map, places.newest()[1], places.speed) == (True, (7.0, 0.0, 0.0), 3.0)


def test_the_nearest_return_is_measured_from_the_cars_body() -> None:
    car = load_car("default")
    assert clearance(np.zeros((0, 2)), car) is None
    assert clearance(np.array([[0.455 + 0.3, 0.0], [0.0, 2.0]]), car) == pytest.approx(0.3)
    assert clearance(np.array([[0.2, -0.155 - 0.25]]), car) == pytest.approx(0.25)
    beams = {"ranges": [1.0, 2.0], "first_beam": 0.0, "beam_step": 0.5 * math.pi}
    np.testing.assert_allclose(points_of(beams, (0.27, 0.0)), [[1.27, 0.0], [0.27, 2.0]], atol=1e-12)
    assert points_of({}, (0.27, 0.0)).shape == (0, 2)


def grid(cells: Any, yaw: float = 0.0) -> Any:
    """A message like nav_msgs/OccupancyGrid: resolution 0.1 m, corner at (1, 2)."""
    table = np.asarray(cells, dtype=np.int8)
    turn = SimpleNamespace(x=0.0, y=0.0, z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    origin = SimpleNamespace(position=SimpleNamespace(x=1.0, y=2.0), orientation=turn)
    info = SimpleNamespace(height=table.shape[0], width=table.shape[1], resolution=0.1, origin=origin)
    return SimpleNamespace(info=info, data=array("b", table.tobytes()))


def test_the_walls_of_a_map_lie_round_its_occupied_cells() -> None:
    cells = np.zeros((20, 30))
    cells[5:10, 10:20] = 100
    cells[15, 3] = -1  # unknown cells are not walls
    (wall,) = walls_of(grid(cells))
    np.testing.assert_allclose(wall.min(axis=0), [2.0, 2.5], atol=1e-9)
    np.testing.assert_allclose(wall.max(axis=0), [3.0, 3.0], atol=1e-9)
    (turned,) = walls_of(grid(cells, yaw=0.5 * math.pi))
    np.testing.assert_allclose(turned.min(axis=0), [0.0, 3.0], atol=1e-9)
    np.testing.assert_allclose(turned.max(axis=0), [0.5, 4.0], atol=1e-9)
    edge = np.zeros((20, 30))
    edge[0, :] = 100
    assert len(walls_of(grid(edge))) == 1, "also at the map's own edge"


def test_a_map_that_cannot_be_is_refused() -> None:
    wrong = grid(np.zeros((4, 4)))
    wrong.info.width = 5
    with pytest.raises(ValueError, match="5 x 4 cells"):
        walls_of(wrong)


def test_a_map_that_is_published_and_does_not_come_is_asked_for_again_ever_more_rarely(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    source = RosSource()
    monkeypatch.setattr(source._link, "published", lambda topic: topic == MAP_TOPIC)
    assert source._lacks_map() and source._map_is_due()
    for tries, silent, again in ((1, 1.0, False), (1, 3.0, True), (3, 3.0, False), (3, 9.0, True), (99, 17.0, True)):
        source._map_tries, source._map_asked = tries, time.monotonic() - silent
        assert source._lacks_map() and source._map_is_due() == again
    source._walls = (np.zeros((2, 2)),)
    assert not source._lacks_map()
    source._walls = ()
    assert source._lacks_map()
