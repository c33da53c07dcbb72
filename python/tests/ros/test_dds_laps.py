"""A simulator and drivers in separate processes complete laps over DDS, in real time."""

from __future__ import annotations

import math
import re
import signal
import time
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

import firstlap
from firstlap.pitwall.ros_source import RosSource
from firstlap.ros.conversions import yaw_of
from firstlap.sim.lidar import Lidar

pytestmark = pytest.mark.dds

LAP_TOLERANCE = 0.02
MOST_LAPS = 5
PATIENT = {"scan_timeout": 1.0, "odom_timeout": 1.0, "pause_limit": 1.0}
"""Long timeouts, so that a busy machine does not stop the car."""
STRICT = {"scan_timeout": 0.0, "odom_timeout": 0.0, "pause_limit": 0.2}


def laps_in(output: str, car: str = "car") -> list[float]:
    """Lap times [s] in a simulator's output."""
    return [float(time) for time in re.findall(rf"^{car}: lap \d+ in ([\d.]+) s", output, re.MULTILINE)]


def test_sure_laps_arena_without_contact_as_fast_as_in_the_plain_simulator(shared_lab: Any) -> None:
    lab = shared_lab
    assert set(lab.probe.set("/firstlap_drive", **PATIENT)) == {""}
    assert lab.probe.trigger("/reset").success
    before, stops_before = len(lab.sim.output), lab.drive.output.count("stopped:")
    markers = lab.probe.hear(MarkerArray, "/firstlap_drive/markers")
    diagnostics = lab.probe.hear(DiagnosticArray, "/diagnostics", 10)
    plain = firstlap.race(firstlap.load_track("arena"), "sure", laps=2).laps[1].time

    lab.until(lambda: markers, "markers")
    assert [one.ns for one in markers[0].markers] == ["left", "right", "path", "lookahead"]
    lab.until(lambda: all(len(one.points) > 0 for one in markers[-1].markers), "points in all of them")
    assert lab.probe.set("/firstlap_drive", velocity_profile__v_max=99.0) != [""]
    assert "v_min" in lab.probe.set("/firstlap_drive", velocity_profile__v_max=1.0)[0]
    assert lab.probe.set("/firstlap_drive", stanley__k_dist=1.0, velocity_profile__v_max=5.0) == ["", ""]
    assert "read-only" in lab.probe.set("/firstlap_drive", driver="gap")[0]

    def agrees() -> bool:
        laps = laps_in(lab.sim.output[before:])[1:]
        assert len(laps) < MOST_LAPS, f"laps of {laps} s, in the plain simulator {plain:.3f} s"
        return any(abs(lap - plain) <= LAP_TOLERANCE * plain for lap in laps)

    lab.until(agrees, "a flying lap as long as in the plain simulator", 150.0)
    assert "contact" not in lab.sim.output[before:]
    assert lab.drive.output.count("stopped:") == stops_before
    told = {value.key: value.value for value in diagnostics[-1].status[0].values}
    assert {"driver", "missed scans", "step [us] p50", "scan to drive [ms] p99", "scan rate [Hz]"} <= set(told)
    assert set(lab.probe.set("/firstlap_drive", **STRICT)) == {""}


def test_a_new_speed_limit_is_kept_at_once(shared_lab: Any) -> None:
    lab = shared_lab
    assert lab.probe.set("/firstlap_drive", speed_limit=0.4) == [""]
    heard = lab.probe.commands["/drive"]
    before = len(heard) + 5

    lab.driven(lambda: sum(one.speed > 0.3 for one in heard[before:]) > 20, "commands")
    assert all(one.speed <= 0.4 + 1e-6 for one in heard[before:])
    assert lab.probe.set("/firstlap_drive", speed_limit=20.0) == [""]


def test_reset_puts_the_car_back_on_the_line(shared_lab: Any) -> None:
    lab = shared_lab
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    track = firstlap.load_track("arena")
    x, y = track.to_arrays()["centerline"][0]
    away = lambda: math.hypot(truth[-1].pose.pose.position.x - x, truth[-1].pose.pose.position.y - y)  # noqa: E731
    lab.driven(lambda: truth and away() > 2.0, "the car is gone")
    lab.probe.trigger("/firstlap_drive/stop")
    assert lab.probe.trigger("/reset").success
    lab.until(lambda: away() < 0.01, "the car is back")


def test_a_kick_turns_the_car_at_once_and_it_drives_on(shared_lab: Any) -> None:
    lab = shared_lab
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    lab.driven(lambda: truth and truth[-1].twist.twist.linear.x > 1.5, "a car that drives")
    before, output = len(truth), len(lab.sim.output)
    assert lab.probe.trigger("/kick").message == "kicked"

    def kicked() -> bool:
        rates = np.array([one.twist.twist.angular.z for one in truth[before - 1 :]])
        return bool((np.abs(np.diff(rates)) > 0.7).any())

    lab.until(kicked, "a yaw rate that no steering makes within a scan")
    lab.driven(lambda: len(truth) > before + 80, "two seconds")
    assert "contact" not in lab.sim.output[output:]


def test_an_initial_pose_puts_the_car_there_and_it_drives_on_from_there(shared_lab: Any) -> None:
    lab = shared_lab
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    place = lab.probe.publisher(PoseWithCovarianceStamped, "/initialpose")
    lab.until(lambda: truth, "the truth")
    message = PoseWithCovarianceStamped()
    message.header.frame_id = "map"
    message.pose.pose = there = truth[-1].pose.pose
    away = lambda: math.hypot(  # noqa: E731
        truth[-1].pose.pose.position.x - there.position.x, truth[-1].pose.pose.position.y - there.position.y
    )
    lab.driven(lambda: away() > 2.0, "the car is elsewhere")
    lab.probe.trigger("/firstlap_drive/stop")
    lab.stays_stopped(15)
    place.publish(message)
    lab.until(lambda: away() < 0.02, "the car is there")
    assert yaw_of(truth[-1].pose.pose.orientation) == pytest.approx(yaw_of(there.orientation), abs=0.02)
    output = len(lab.sim.output)
    lab.resume()
    lab.driven(lambda: away() > 2.0, "the car drives on")
    assert "contact" not in lab.sim.output[output:]


def test_two_cars_in_their_namespaces_see_each_other_and_lap(lab: Any) -> None:
    lab.probe.hear_drive("/car1/drive")
    lab.probe.hear_drive("/car2/drive")
    scans = lab.probe.hear(LaserScan, "/car2/scan")
    truth = lab.probe.hear(Odometry, "/car2/ground_truth/odom")
    lab.start_sim("arena", "--cars", "2")
    lab.until(lambda: scans, "scans")
    lab.until(lambda: truth, "the truth")
    place = truth[-1].pose.pose
    yaw = yaw_of(place.orientation)
    laser = (place.position.x + 0.27 * math.cos(yaw), place.position.y + 0.27 * math.sin(yaw), yaw)
    walls = Lidar(firstlap.load_track("arena")).scan(*laser)
    nearer = np.flatnonzero(np.asarray(scans[-1].ranges) < walls - 0.3)
    assert len(nearer) > 10, "beams that end on the car ahead"
    assert 2.2 < np.asarray(scans[-1].ranges)[nearer].min() < 2.7, "its tail is 2.6 m before the laser along the line"
    for car, limit in (("car1", "4.0"), ("car2", "3.0")):
        lab.start("drive", "--go", "--namespace", car, "--ros-args", "-p", f"speed_limit:={limit}")
    source = RosSource(["--ros-args", "-r", "__ns:=/car2", "-p", "base_frame:=car2/base_link"], domain=lab.domain)
    source.start()

    def planned() -> bool:
        frame = source.latest()
        return bool(frame and frame.pose and "path" in frame.trace)

    try:
        lab.driven(planned, "car2 is watched", "/car1", "/car2")
        frame, place = source.latest(), truth[-1].pose.pose.position
        assert source.title == "/car2/firstlap_drive over ROS 2"
        assert frame is not None
        assert frame.pose is not None
        assert math.hypot(frame.pose[0] - place.x, frame.pose[1] - place.y) < 2.0, "car2's place"
    finally:
        source.close()

    def lapped() -> bool:
        return all(laps_in(lab.sim.output, car) for car in ("car1", "car2"))

    lab.driven(lapped, "a lap of each", "/car1", "/car2", seconds=150.0)
    assert "contact" not in lab.sim.output


def test_a_stack_for_f1tenth_gym_ros_finds_its_names_and_a_driver_can_use_them(lab: Any) -> None:
    odometry = lab.probe.hear(Odometry, "/ego_racecar/odom")
    scans = lab.probe.hear(LaserScan, "/scan")
    lab.start("sim", "arena", "--gym-names")
    lab.until(lambda: odometry and scans, "its topics")
    assert (odometry[-1].header.frame_id, odometry[-1].child_frame_id) == ("map", "ego_racecar/base_link")
    assert scans[-1].header.frame_id == "ego_racecar/laser"
    assert len(scans[-1].ranges) == 1080
    arguments = ("odom_topic:=ego_racecar/odom", "base_frame:=ego_racecar/base_link")
    lab.start("drive", "--go", "--driver", "gap", "--ros-args", *(text for one in arguments for text in ("-p", one)))
    lab.resume()
    x = odometry[-1].pose.pose.position.x
    lab.driven(lambda: abs(odometry[-1].pose.pose.position.x - x) > 1.0, "the car has moved")


def test_simulated_time_runs_at_a_factor_the_driver_follows_it_and_stops_when_it_stands(lab: Any) -> None:
    clock = lab.probe.hear(Clock, "/clock")
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    lab.start_sim("arena", "--factor", "0.5")
    lab.start_drive("--sim-time")
    lab.driven(lambda: clock and truth and lab.probe.moves(), "a car that drives by a simulated clock")
    sim_began, began = clock[-1].clock, time.monotonic()
    x = truth[-1].pose.pose.position.x
    lab.driven(lambda: truth[-1].pose.pose.position.x > x + 4.0, "the car has driven 4 m")
    passed = clock[-1].clock.sec - sim_began.sec + 1e-9 * (clock[-1].clock.nanosec - sim_began.nanosec)
    assert 0.0 < passed <= 0.5 * (time.monotonic() - began) + 0.1, "never faster than the factor"
    assert "contact" not in lab.sim.output
    lab.resume()
    lab.stops_in_time(lambda: lab.sim.send(signal.SIGSTOP), known=True)
    assert re.search(r"stopped: (/clock has not advanced|no scan)", lab.drive.output)
