"""Processes that end, hang or die: the car is stopped."""

from __future__ import annotations

import re
import signal
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition
from nav_msgs.msg import Odometry

pytestmark = pytest.mark.dds

LIMIT = 0.3
PERIOD = 0.025
STANDS = 0.15
"""[m/s] Maximum measured speed of a stationary car with a noisy wheel sensor."""
BRAKING = 2.0
"""[m/s^2] Minimum deceleration after the stop command; the car's is several times larger."""


def test_the_driver_stops_when_the_other_side_is_paused_and_does_not_go_on_after(shared_lab: Any) -> None:
    lab = shared_lab
    lab.stops_in_time(lambda: lab.sim.send(signal.SIGSTOP), known=True)
    lab.sim.send(signal.SIGCONT)
    lab.stays_stopped(30)


def test_the_driver_stops_when_the_other_side_is_killed_and_waits_for_consent_when_it_is_back(shared_lab: Any) -> None:
    lab = shared_lab
    lab.stops_in_time(lambda: lab.sim.send(signal.SIGKILL), known=True)
    lab.sim.wait()
    scans = lab.probe.hear(Odometry, "/odom")
    lab.start_sim()
    scans.clear()
    lab.until(lambda: len(scans) > 20, "the new simulator")
    lab.stays_stopped(15)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_a_signal_stops_the_car_and_ends_the_driver_in_order(shared_lab: Any, number: int, code: int) -> None:
    lab = shared_lab
    lab.stops_in_time(lambda: lab.drive.send(number), known=True)
    lab.until(lambda: lab.drive.over, "its end")
    assert lab.drive.wait() == code
    assert lab.probe.speed() == 0.0
    assert "Traceback" not in lab.drive.output


def stands_soon(lab: Any, odometry: list[Any], waits: dict[str, int]) -> None:
    """Asserts that the car brakes from LIMIT on, by its odometry. Time is counted in scan periods, because a delayed
    simulator skips the lost time."""
    before = len(odometry)
    lab.until(lambda: odometry[-1].twist.twist.linear.x < STANDS, "the car stands")
    speed = max(one.twist.twist.linear.x for one in odometry[before - 1 :])
    spent, kept = PERIOD * (len(odometry) - before), lab.kept_since(waits)
    assert spent <= LIMIT + speed / BRAKING + kept, f"{spent:.2f} s from {speed:.1f} m/s, {kept:.2f} s of the machine's"


def test_a_car_whose_driver_is_killed_is_stopped_by_the_simulators_own_timeout(shared_lab: Any) -> None:
    lab = shared_lab
    odometry = lab.probe.hear(Odometry, "/odom")
    lab.driven(lambda: odometry and odometry[-1].twist.twist.linear.x > 1.0, "a car that drives")
    waits = lab.waits()
    lab.drive.send(signal.SIGKILL)
    lab.drive.wait()
    stands_soon(lab, odometry, waits)


def test_a_driver_in_a_debugger_is_replaced_by_the_timeout_and_stays_stopped_when_it_goes_on(shared_lab: Any) -> None:
    lab = shared_lab
    odometry = lab.probe.hear(Odometry, "/odom")
    lab.driven(lambda: odometry and odometry[-1].twist.twist.linear.x > 1.0, "a car that drives")
    waits = lab.waits()
    lab.drive.send(signal.SIGSTOP)
    stands_soon(lab, odometry, waits)
    lab.until(lab.silent, "silence")
    before = len(lab.drive.output)
    lab.drive.send(signal.SIGCONT)
    lab.stays_stopped(30)
    assert re.search("stopped: (the node did not run|no scan) for", lab.drive.output[before:])


def test_a_node_that_is_deactivated_stops_the_car_and_then_leaves_the_topic_to_others(shared_lab: Any) -> None:
    lab = shared_lab
    made: list[bool] = []
    lab.stops_in_time(lambda: made.append(lab.probe.change_state(Transition.TRANSITION_DEACTIVATE)), known=True)
    assert made == [True]
    lab.until(lab.silent, "silence")
    assert lab.probe.speed() == 0.0
    answer = lab.probe.trigger("/firstlap_drive/resume")
    assert not answer.success
    assert "not active" in answer.message
    lab.until(lambda: lab.probe.change_state(Transition.TRANSITION_ACTIVATE), "it is active again")


def test_a_node_that_is_shut_down_by_its_lifecycle_stops_the_car_for_good(shared_lab: Any) -> None:
    lab = shared_lab
    shut = lambda: lab.probe.change_state(Transition.TRANSITION_ACTIVE_SHUTDOWN)  # noqa: E731
    lab.stops_in_time(shut, known=True)
    lab.until(lab.silent, "silence")
    assert lab.probe.speed() == 0.0
    assert not lab.probe.change_state(Transition.TRANSITION_ACTIVATE)
    lab.drive.send(signal.SIGTERM)
    assert lab.drive.wait() == 0
