"""The odometry check of a running node, without ROS: what stops the car, and what is only a remark."""

from __future__ import annotations

import math
import sys
import time

import numpy as np
import pytest
from waiting import PATIENCE

import firstlap
from firstlap import _core
from firstlap.perception.scan import Mount
from firstlap.ros.odometry_watch import OdometryWatch
from firstlap.sim.lidar import Lidar

PERIOD = 0.05
MOUNT = Mount(0.27, 0.0, 0.0, False)


class Car:
    """A car that follows the centerline of a track, with odometry that may be wrong."""

    def __init__(self, track: firstlap.Track) -> None:
        self.lidar = Lidar(track)
        line = np.asarray(track.to_arrays()["centerline"])
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
        self.line, self.way = line[:, :2], way
        self.s = self.time = 0.0
        self.watch = OdometryWatch()

    def pose(self, s: float) -> tuple[float, float, float]:
        """Pose of base_link at arc length s [m]."""
        x, y = (np.interp([s, s + 0.3], self.way, column) for column in self.line.T)
        return float(x[0]), float(y[0]), math.atan2(y[1] - y[0], x[1] - x[0])

    def drive(
        self, seconds: float, speed: float, forward: float = 1.0, turn: float = 1.0, commanded: float = 0.0
    ) -> None:
        """forward, turn: scales of the true values. commanded: speed [m/s], 0 for none."""
        for _ in range(round(seconds / PERIOD)):
            before = self.pose(self.s)
            self.s += speed * PERIOD
            self.time += PERIOD
            x, y, yaw = self.pose(self.s)
            rate = math.remainder(yaw - before[2], 2.0 * math.pi) / PERIOD
            self.watch.note((self.time, forward * speed, 0.0, turn * rate, 0.0, 0.0, 0.0))
            if commanded:
                self.watch.add_command(self.time, commanded)
            ranges = self.lidar.scan(x, y, yaw)
            step = float(self.lidar.angles[1] - self.lidar.angles[0])
            scan = _core.LaserScan(ranges, float(self.lidar.angles[0]), step, 0.0, 0.06, 30.0)
            self.watch.add_scan(scan, self.time, MOUNT)
            self.watch.work()


@pytest.fixture
def car(arena: firstlap.Track) -> Car:
    return Car(arena)


def test_a_car_that_stands_and_is_pushed_with_honest_odometry_may_drive(car: Car) -> None:
    assert "nothing" in car.watch.summary
    car.drive(2.0, 0.0)
    car.drive(3.0, 0.8)
    assert (car.watch.reason, car.watch.remarks) == ("", ())
    assert "the scans" in car.watch.summary


@pytest.mark.parametrize(
    ("forward", "words"), [(-1.0, "wrong sign"), (3.6, "km/h instead of m/s"), (0.0, "stands at 0")]
)
def test_a_push_shows_wrong_odometry_and_a_push_with_right_odometry_takes_it_back(
    car: Car, forward: float, words: str
) -> None:
    car.drive(3.0, 0.8, forward)
    assert words in car.watch.reason
    (news,) = car.watch.take_news()
    assert words in news
    assert car.watch.take_news() == [], "said once"
    car.drive(3.0, 0.8)
    assert car.watch.reason == ""


def test_scans_that_moved_while_odometry_stood_are_forgotten_after_a_while_for_the_car_may_have_been_carried(
    car: Car,
) -> None:
    car.drive(3.0, 0.8, 0.0)
    assert car.watch.reason
    car.drive(16.0, 0.0)
    assert car.watch.reason == ""


def test_a_wrong_sign_is_not_forgotten_while_the_car_stands(car: Car) -> None:
    car.drive(3.0, 0.8, -1.0)
    car.drive(16.0, 0.0)
    assert "wrong sign" in car.watch.reason


def test_odometry_that_stops_at_0_while_driving_is_found_within_two_seconds(car: Car) -> None:
    car.drive(3.0, 1.5, commanded=1.5)
    assert car.watch.reason == ""
    car.drive(2.0, 1.5, 0.0, commanded=1.5)
    assert car.watch.reason


def test_wheels_on_a_stand_are_told_and_do_not_stop_the_car(car: Car) -> None:
    car.drive(1.0, 0.0)
    for _ in range(60):
        car.time += PERIOD
        car.watch.note((car.time, 0.8, 0.0, 0.0, 0.0, 0.0, 0.0))
        car.watch.add_command(car.time, 0.8)
        assert car.watch._waiting is not None
        car.watch.add_scan(car.watch._waiting.scan, car.time, MOUNT)
        car.watch.work()
    assert car.watch.reason == ""
    assert "on a stand" in car.watch.summary


def test_the_thread_works_and_ends(car: Car) -> None:
    car.watch.start()
    try:
        deadline = time.monotonic() + PATIENCE
        while not car.watch.compared and time.monotonic() < deadline:
            car.drive(PERIOD, 0.8)
            time.sleep(0.02)
        assert car.watch.compared
    finally:
        car.watch.stop()
    assert car.watch.remarks == ()


def test_steps_of_a_laser_that_sat_elsewhere_do_not_count(car: Car, monkeypatch: pytest.MonkeyPatch) -> None:
    car.drive(1.0, 1.0)
    assert len(car.watch.steps()) > 3
    monkeypatch.setattr(sys.modules[__name__], "MOUNT", Mount(0.1, 0.0, 0.0, False))
    car.drive(0.2, 1.0)
    assert len(car.watch.steps()) <= 2
