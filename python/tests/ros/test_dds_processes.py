"""Processes that end, hang and die: the car is told to stop, whoever is left."""

from __future__ import annotations

import signal
import time
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition
from nav_msgs.msg import Odometry
from probe import STALL
from std_msgs.msg import Bool

pytestmark = pytest.mark.dds

LIMIT = 0.3
STANDS = 0.15
"""[m/s] that a car with a noisy wheel sensor measures at most when it stands."""
BRAKING = 2.0
"""[m/s^2] at least, from when the stop is commanded; the car's own is several times that."""


def driving(lab: Any, *arguments: str) -> tuple[Any, Any]:
    """A simulator and a driver that laps."""
    sim, drive = lab.start("sim", "arena"), lab.start("drive", *arguments)
    lab.resume()
    return sim, drive


def stop_after(lab: Any, since: float) -> float:
    """[s] from a moment to the first stop after it."""
    heard = lab.probe.commands["/drive"]
    lab.until(lambda: heard and heard[-1].time >= since and heard[-1].speed == 0.0, "a stop")
    return next(one.time for one in heard if one.time >= since and one.speed == 0.0) - since


def in_time(lab: Any, late: float) -> None:
    """The stop came within LIMIT, unless the probe was given no time either."""
    assert late <= LIMIT + max(lab.probe.stalled - STALL, 0.0), f"{late:.3f} s, probe late {lab.probe.stalled:.3f} s"


def test_the_driver_stops_when_the_other_side_is_killed(lab: Any) -> None:
    sim, _drive = driving(lab)
    lab.probe.stalled = 0.0
    sim.send(signal.SIGKILL)
    in_time(lab, stop_after(lab, time.monotonic()))


def test_the_driver_stops_when_the_other_side_is_paused_and_does_not_go_on_after(lab: Any) -> None:
    sim, _drive = driving(lab)
    lab.probe.stalled = 0.0
    sim.send(signal.SIGSTOP)
    in_time(lab, stop_after(lab, time.monotonic()))
    sim.send(signal.SIGCONT)
    heard = lab.probe.commands["/drive"]
    before = len(heard)
    lab.until(lambda: len(heard) > before + 40, "more commands")
    assert {one.speed for one in heard[before:]} == {0.0}
    lab.resume()


def test_sigterm_stops_the_car_and_ends_the_driver_in_order(lab: Any) -> None:
    _sim, drive = driving(lab)
    lab.probe.stalled = 0.0
    drive.send(signal.SIGTERM)
    in_time(lab, stop_after(lab, time.monotonic()))
    lab.until(lambda: drive.process.poll() is not None, "its end")
    assert drive.wait() == 0
    assert lab.probe.speed() == 0.0
    assert "Traceback" not in drive.said


def stands_soon(lab: Any, odometry: list[Any]) -> None:
    """The car, by its own odometry, is braked from LIMIT on."""
    speed = odometry[-1].twist.twist.linear.x
    before = len(odometry)
    lab.until(lambda: odometry[-1].twist.twist.linear.x < STANDS, "the car stands")
    spent = 0.025 * (len(odometry) - before)
    assert spent <= LIMIT + speed / BRAKING, f"{spent:.2f} s from {speed:.1f} m/s"


def test_a_car_whose_driver_is_killed_is_stopped_by_the_simulators_own_timeout(lab: Any) -> None:
    odometry = lab.probe.hear(Odometry, "/odom")
    _sim, drive = driving(lab)
    drive.send(signal.SIGKILL)
    lab.probe.spin(0.0)
    stands_soon(lab, odometry)


def test_a_driver_in_a_debugger_is_replaced_by_the_timeout_and_stays_stopped_when_it_goes_on(lab: Any) -> None:
    odometry = lab.probe.hear(Odometry, "/odom")
    _sim, drive = driving(lab)
    drive.send(signal.SIGSTOP)
    stands_soon(lab, odometry)
    heard = lab.probe.commands["/drive"]
    lab.until(lambda: lab.probe.last_spin and not _comes(lab, heard), "silence")
    before = len(heard)
    drive.send(signal.SIGCONT)
    lab.until(lambda: len(heard) > before + 40, "more commands")
    assert {one.speed for one in heard[before:]} == {0.0}
    assert "did not run for" in drive.said
    lab.resume()


def _comes(lab: Any, heard: list[Any]) -> bool:
    """Whether commands still come: those on their way when the driver was paused."""
    before = len(heard)
    for _ in range(5):
        lab.probe.spin(0.01)
    return len(heard) > before


def test_a_node_that_is_deactivated_stops_the_car_and_then_leaves_the_topic_to_others(lab: Any) -> None:
    driving(lab)
    lab.probe.stalled = 0.0
    since = time.monotonic()
    assert lab.probe.change_state(Transition.TRANSITION_DEACTIVATE)
    in_time(lab, stop_after(lab, since))
    heard = lab.probe.commands["/drive"]
    lab.until(lambda: not _comes(lab, heard), "silence")
    assert lab.probe.speed() == 0.0
    answer = lab.probe.trigger("/firstlap_drive/resume")
    assert not answer.success
    assert "not active" in answer.message
    assert lab.probe.change_state(Transition.TRANSITION_ACTIVATE)
    lab.resume()


def test_a_node_is_not_activated_while_something_is_missing(lab: Any) -> None:
    drive = lab.start("drive", "--no-start")
    assert lab.probe.change_state(Transition.TRANSITION_CONFIGURE)
    assert not lab.probe.change_state(Transition.TRANSITION_ACTIVATE)
    assert lab.until(lambda: "not driving: no scan yet" in drive.said, "the reason")
    assert lab.probe.commands["/drive"] == []


def test_a_dead_man_button_stops_when_released_or_silent_and_drives_when_pressed_anew(lab: Any) -> None:
    lab.start("sim", "arena")
    lab.start("drive", "--ros-args", "-p", "deadman_topic:=deadman", "-p", "deadman_timeout:=0.2")
    button = lab.probe.node.create_publisher(Bool, "/deadman", 1)
    held = [False, True]
    lab.probe.node.create_timer(0.02, lambda: held[1] and button.publish(Bool(data=held[0])))
    lab.until(button.get_subscription_count, "the driver listens")

    def pressed_until_it_drives() -> bool:
        if lab.probe.speed() > 0.5:
            return True
        held[0] = False
        for _ in range(5):
            lab.probe.spin(0.02)
        held[0] = True
        for _ in range(25):
            lab.probe.spin(0.02)
        return lab.probe.speed() > 0.5

    lab.until(pressed_until_it_drives, "drives while held")
    lab.probe.stalled = 0.0
    held[0] = False
    in_time(lab, stop_after(lab, time.monotonic()))
    lab.until(pressed_until_it_drives, "drives when pressed anew")
    lab.probe.stalled = 0.0
    held[1] = False
    in_time(lab, stop_after(lab, time.monotonic()) - 0.02)
    held[1] = True
    heard = lab.probe.commands["/drive"]
    before = len(heard)
    lab.until(lambda: len(heard) > before + 40, "more commands")
    assert {one.speed for one in heard[before:]} == {0.0}, "a button that was held through the silence is no consent"
    lab.until(pressed_until_it_drives, "drives when pressed anew")
