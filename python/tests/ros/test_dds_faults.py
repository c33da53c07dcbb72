"""All faults of sources, with real processes: the car is stopped within 0.3 s and stays stopped."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from std_msgs.msg import Bool

pytestmark = pytest.mark.dds

Act = Callable[[], object]
ATTEMPTS = 5
"""Number of attempts: if a busy machine caused a stop just before the fault, the fault is repeated."""

FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "no scan": ({"drop_scans": 1.0}, "no scan for"),
    "no odometry": ({"drop_odometry": 1.0}, "no odom for"),
    "frozen odometry": ({"freeze_odometry": True}, "the same stamp again"),
    "stale stamps": ({"stamp_offset": -2.0}, "before the last one"),
    "stamps from the future": ({"stamp_offset": 2.0}, "in the future"),
    "backward stamps": ({"backward_stamps": True}, "before the last one"),
    "a flood of NaN": ({"nan_scans": True}, "0 of 1081 beams return"),
    "odometry of NaN": ({"nan_odometry": True}, "not finite"),
    "a scan that hardly has a beam": ({"scan_beams": 1}, "1 beams; at least 2"),
    "a frame that does not exist": ({"scan_frame": "nowhere"}, "no transform from base_link to nowhere"),
    "scans that come late": ({"delay": 0.5}, "no scan for"),
}
"""Faults of the simulator, and the driving node's reason for the stop."""


def made_good(wrong: dict[str, Any]) -> dict[str, Any]:
    """The same parameters with their defaults."""
    from firstlap.ros.names import FAULTS as ROWS

    return {row.name: row.default for row in ROWS if row.name in wrong}


def stops(lab: Any, fault: Act, undo: Act, reason: str, lasts: bool = True, known: bool = False) -> None:
    """The stop is in time and for the right reason; only consent ends it, and it is refused while the fault lasts."""
    for _attempt in range(ATTEMPTS):
        lab.well()
        lab.stops_in_time(fault, known=known)
        lab.stays_stopped(15)
        assert not (lasts and lab.probe.trigger("/firstlap_drive/resume").success), "consent while the fault lasts"
        undo()
        lab.stays_stopped(25)
        if reason in (output := lab.drive.output.rpartition("stopped: ")[2]):
            return
    raise AssertionError(output)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_a_source_stops_the_car_until_the_driver_consents(shared_lab: Any, fault: str) -> None:
    lab = shared_lab
    wrong, reason = FAULTS[fault]
    stops(
        lab,
        lambda: lab.probe.set("/firstlap_sim", **wrong),
        lambda: lab.probe.set("/firstlap_sim", **made_good(wrong)),
        reason,
    )


def test_an_emergency_stop_is_obeyed_and_forbids_to_go_on_while_it_is_pressed(shared_lab: Any) -> None:
    lab = shared_lab
    button = lab.probe.publisher(Bool, "/emergency_stop")

    def release() -> None:
        answer = lab.probe.trigger("/firstlap_drive/resume")
        assert (answer.success, answer.message) == (False, "emergency stop")
        button.publish(Bool(data=False))

    stops(lab, lambda: button.publish(Bool(data=True)), release, "emergency stop", known=True)


def test_the_service_stop_stops(shared_lab: Any) -> None:
    lab = shared_lab
    stops(lab, lambda: lab.probe.trigger("/firstlap_drive/stop"), lambda: None, "~/stop", lasts=False, known=True)


def test_no_command_ever_left_the_limits(shared_lab: Any) -> None:
    heard = shared_lab.probe.commands["/drive"]
    assert len(heard) > 100
    assert all(0.0 <= one.speed <= 5.0 and abs(one.steering_angle) <= 0.4189 + 1e-6 for one in heard)
