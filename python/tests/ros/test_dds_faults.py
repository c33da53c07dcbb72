"""Every fault of a source, with real processes: the car is told to stop within 0.3 s and stays stopped."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest
from probe import STALL, Heard
from std_msgs.msg import Bool

LIMIT = 0.3
STOPPED_FOR = 40
"""Stops in a row after the fault is over: nothing starts the car again."""

FAULTS: dict[str, dict[str, Any]] = {
    "no scan": {"drop_scans": 1.0},
    "no odometry": {"drop_odometry": 1.0},
    "frozen odometry": {"freeze_odometry": True},
    "stale stamps": {"stamp_offset": -2.0},
    "stamps from the future": {"stamp_offset": 2.0},
    "backward stamps": {"backward_stamps": True},
    "a flood of NaN": {"nan_scans": True},
    "odometry of NaN": {"nan_odometry": True},
    "a scan of the wrong size": {"scan_beams": 500},
    "a frame that does not exist": {"scan_frame": "nowhere"},
    "scans that come late": {"delay": 0.5},
}
WELL: dict[str, Any] = {
    "drop_scans": 0.0,
    "drop_odometry": 0.0,
    "freeze_odometry": False,
    "stamp_offset": 0.0,
    "backward_stamps": False,
    "nan_scans": False,
    "nan_odometry": False,
    "scan_beams": 0,
    "scan_frame": "",
    "delay": 0.0,
}


def first_stop(lab: Any, since: float) -> Heard:
    """The first command to stand after a moment."""
    heard = lab.probe.commands["/drive"]
    found = lab.until(
        lambda: next((one for one in reversed(heard) if one.time >= since and one.speed == 0.0), None), "a stop"
    )
    assert found
    return next(one for one in heard if one.time >= since and one.speed == 0.0)


def stops_in_time(lab: Any, fault: Callable[[], None], undo: Callable[[], None]) -> None:
    """Whether the stop comes within LIMIT. Where the machine gave the probe no time meanwhile, it is tried again."""
    for _attempt in range(8):
        lab.resume()
        lab.probe.stalled = 0.0
        fault()
        since = time.monotonic()
        stop = first_stop(lab, since)
        stalled = lab.probe.stalled
        stays_stopped(lab)
        undo()
        stays_stopped(lab)
        if stop.time - since <= LIMIT:
            return
        if stalled <= STALL:
            raise AssertionError(f"stopped after {stop.time - since:.3f} s, the machine being idle")
    pytest.skip("the machine was too busy to measure 0.3 s")


def stays_stopped(lab: Any) -> None:
    """No command but to stand comes any more."""
    heard = lab.probe.commands["/drive"]
    before = len(heard)
    lab.until(lambda: len(heard) >= before + STOPPED_FOR, "more stops")
    assert {one.speed for one in heard[before:]} == {0.0}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_a_source_stops_the_car_until_the_driver_consents(shared_lab: Any, fault: str) -> None:
    lab = shared_lab
    stops_in_time(
        lab,
        lambda: lab.probe.set("/firstlap_sim", **FAULTS[fault]),
        lambda: lab.probe.set("/firstlap_sim", **{name: WELL[name] for name in FAULTS[fault]}),
    )


def test_an_emergency_stop_is_obeyed_and_forbids_to_go_on_while_it_is_pressed(shared_lab: Any) -> None:
    lab = shared_lab
    button = lab.probe.publisher(Bool, "/emergency_stop")
    button_down = lambda: button.publish(Bool(data=True))  # noqa: E731

    def release() -> None:
        answer = lab.probe.trigger("/firstlap_drive/resume")
        assert (answer.success, answer.message) == (False, "emergency stop")
        button.publish(Bool(data=False))

    stops_in_time(lab, button_down, release)


def test_the_service_stop_stops(shared_lab: Any) -> None:
    stops_in_time(shared_lab, lambda: shared_lab.probe.trigger("/firstlap_drive/stop"), lambda: None)


def test_no_command_ever_left_the_limits(shared_lab: Any) -> None:
    heard = shared_lab.probe.commands["/drive"]
    assert len(heard) > 100
    assert all(0.0 <= one.speed <= 5.0 and abs(one.steering_angle) <= 0.4189 + 1e-6 for one in heard)
