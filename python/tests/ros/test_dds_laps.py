"""A simulator and drivers in processes of their own lap over DDS, in real time."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

import firstlap
from firstlap.ros.conversions import yaw_of
from firstlap.simulate import Lidar

pytestmark = pytest.mark.dds

LAP_TOLERANCE = 0.02


def laps_of(sim: Any) -> list[dict[str, Any]]:
    """The cars in the summary of a simulator that has ended."""
    found: list[dict[str, Any]] = json.loads(sim.said[sim.said.index("{") :])["cars"]
    return found


def drives_to_the_end(lab: Any, sim: Any, *cars: str) -> list[dict[str, Any]]:
    """Waits for the laps. A busy machine may starve a node until it stops: the driver consents again."""

    def over() -> bool:
        for car in cars or ("",):
            heard = lab.probe.commands[f"{car}/drive"]
            if heard and heard[-1].speed == 0.0:
                lab.probe.trigger(f"{car}/firstlap_drive/resume")
        lab.probe.spin(0.05)
        return sim.process.poll() is not None

    lab.until(over, "the laps", 120.0)
    return laps_of(sim)


def test_sure_laps_arena_without_contact_as_fast_as_in_the_plain_simulator(lab: Any) -> None:
    sim = lab.start("sim", "arena", "--laps", "2", "--json")
    drive = lab.start("drive", "--setup", "sure")
    markers = lab.probe.hear(MarkerArray, "/firstlap_drive/markers")
    diagnostics = lab.probe.hear(DiagnosticArray, "/diagnostics", 10)
    lab.driving()
    lab.until(lambda: markers, "markers")
    assert [one.ns for one in markers[0].markers] == ["left", "right", "path", "lookahead"]
    assert all(len(one.points) > 0 for one in markers[-1].markers)

    assert lab.probe.set("/firstlap_drive", velocity_profile__v_max=99.0) != [""]
    contradiction = lab.probe.set("/firstlap_drive", velocity_profile__v_max=1.0)
    assert "v_min" in contradiction[0]
    assert lab.probe.set("/firstlap_drive", stanley__k_dist=1.0, velocity_profile__v_max=5.0) == ["", ""]
    assert "read-only" in lab.probe.set("/firstlap_drive", driver="gap")[0]

    (car,) = drives_to_the_end(lab, sim)
    assert car["contacts"] == 0
    plain = firstlap.race(firstlap.load_track("arena"), "sure", laps=2)
    starved = "stopped:" in drive.said.partition("stopped: no scan")[0]
    assert starved or car["laps"][1]["time"] == pytest.approx(plain.laps[1].time, rel=LAP_TOLERANCE)
    told = {value.key: value.value for value in diagnostics[-1].status[0].values}
    assert {"driver", "missed scans", "step [us] p50", "scan to drive [ms] p99", "scan rate [Hz]"} <= set(told)


def test_a_new_speed_limit_is_kept_at_once(lab: Any) -> None:
    lab.start("sim", "arena")
    lab.start("drive")
    lab.resume()
    assert lab.probe.set("/firstlap_drive", speed_limit=0.4) == [""]
    heard = lab.probe.commands["/drive"]
    before = len(heard) + 5
    lab.until(lambda: len(heard) > before + 40, "commands")
    assert all(one.speed <= 0.4 + 1e-6 for one in heard[before:])
    assert any(one.speed > 0.3 for one in heard[before:])


def test_two_cars_in_their_namespaces_see_each_other_and_lap(lab: Any) -> None:
    lab.probe.hear_drive("/car1/drive")
    lab.probe.hear_drive("/car2/drive")
    scans = lab.probe.hear(LaserScan, "/car2/scan")
    truth = lab.probe.hear(Odometry, "/car2/ground_truth/odom")
    sim = lab.start("sim", "arena", "--cars", "2", "--laps", "1", "--json")
    lab.until(lambda: scans, "scans")
    lab.until(lambda: truth, "the truth")
    place = truth[-1].pose.pose
    yaw = yaw_of(place.orientation)
    laser = (place.position.x + 0.27 * math.cos(yaw), place.position.y + 0.27 * math.sin(yaw), yaw)
    walls = Lidar(firstlap.load_track("arena")).scan(*laser)
    nearer = np.flatnonzero(np.asarray(scans[-1].ranges) < walls - 0.3)
    assert len(nearer) > 10, "beams that end on the car ahead"
    assert 2.2 < np.asarray(scans[-1].ranges)[nearer].min() < 2.7, "its tail is 2.6 m before the laser along the line"
    for car, limit in (("car1", "3.0"), ("car2", "2.0")):
        lab.start("drive", "--namespace", car, "--ros-args", "-p", f"speed_limit:={limit}")
    cars = drives_to_the_end(lab, sim, "/car1", "/car2")
    assert [car["name"] for car in cars] == ["car1", "car2"]
    assert all(len(car["laps"]) >= 1 and car["contacts"] == 0 for car in cars)


def test_a_stack_for_f1tenth_gym_ros_finds_its_names_and_a_driver_can_use_them(lab: Any) -> None:
    odometry = lab.probe.hear(Odometry, "/ego_racecar/odom")
    scans = lab.probe.hear(LaserScan, "/scan")
    lab.start("sim", "arena", "--gym-names")
    lab.until(lambda: odometry and scans, "its topics")
    assert (odometry[-1].header.frame_id, odometry[-1].child_frame_id) == ("map", "ego_racecar/base_link")
    assert scans[-1].header.frame_id == "ego_racecar/laser"
    assert len(scans[-1].ranges) == 1080
    arguments = ("odom_topic:=ego_racecar/odom", "base_frame:=ego_racecar/base_link")
    lab.start("drive", "--driver", "gap", "--ros-args", *(text for one in arguments for text in ("-p", one)))
    lab.resume()


def test_reset_puts_the_car_back_on_the_line(lab: Any) -> None:
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    lab.start("sim", "arena")
    start = lab.until(lambda: truth, "the truth")[0].pose.pose.position
    lab.start("drive")
    lab.resume()
    away = lambda: abs(truth[-1].pose.pose.position.x - start.x) + abs(truth[-1].pose.pose.position.y - start.y)  # noqa: E731
    lab.until(lambda: away() > 2.0, "the car is gone")
    lab.probe.trigger("/firstlap_drive/stop")
    assert lab.probe.trigger("/reset").success
    lab.until(lambda: away() < 0.01, "the car is back")


def test_simulated_time_runs_at_a_factor_and_the_driver_follows_it(lab: Any) -> None:
    sim = lab.start("sim", "arena", "--factor", "0.5", "--laps", "1", "--json")
    lab.start("drive", "--sim-time")
    (car,) = drives_to_the_end(lab, sim)
    assert car["contacts"] == 0
    assert car["laps"][0]["time"] < 20.0
