"""Wrong odometry: the node stops, reports the contradiction, and does not start again."""

from __future__ import annotations

import json
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition

pytestmark = pytest.mark.dds


def settings(**values: object) -> list[str]:
    """The parameters as command-line arguments."""
    return ["--ros-args", *(text for name, value in values.items() for text in ("-p", f"{name}:={value}"))]


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"odometry_speed_scale": -1.0}, "wrong sign"),
        ({"odometry_speed_scale": 3.6}, "km/h instead of m/s"),
        ({"odometry_speed_scale": 0.0}, "stands at 0"),
        ({"odometry_yaw_rate_scale": 57.3}, "degrees per second instead of radians"),
        ({"odometry_in_map": "true"}, "frame of the car"),
    ],
    ids=["negated", "km/h", "0", "deg/s", "frame"],
)
def test_a_car_whose_odometry_lies_is_stopped_and_does_not_start_again(
    lab: Any, fault: dict[str, object], words: str
) -> None:
    lab.start_sim("arena", *settings(**fault))
    lab.start_drive("--go", *settings(speed_limit=2.0))

    def stopped() -> bool:
        lab.probe.spin(0.05)
        if words not in lab.drive.output and lab.probe.commands["/drive"] and lab.probe.speed() == 0.0:
            lab.probe.trigger("/firstlap_drive/resume")  # stopped for another reason by a busy machine
        return "stopped: " in lab.drive.output and words in lab.drive.output

    lab.until(stopped, "a stop for the odometry", 120.0)
    lab.stays_stopped(10)
    refused = lab.probe.trigger("/firstlap_drive/resume")
    assert not refused.success
    assert words in refused.message
    assert lab.probe.change_state(Transition.TRANSITION_DEACTIVATE)
    assert not lab.probe.change_state(Transition.TRANSITION_ACTIVATE)
    assert "not driving: " in lab.drive.output
    assert "contact" not in lab.sim.output


def test_preflight_compares_commanded_and_measured_speed_with_the_scans(lab: Any) -> None:
    lab.start_sim("arena", *settings(odometry_speed_scale=1.25))
    for _attempt in range(6):
        running = lab.start("preflight", "--seconds", "1", "--json", "--move", "--yes")
        lab.until(lambda running=running: running.over, "its end")
        checks = {one["name"]: one for one in json.loads(running.output)["checks"]}
        if "drive forward" in checks:
            break
    else:
        pytest.skip("the machine is so busy that preflight did not let it drive")
    assert checks["drive forward"]["good"] is False
    assert "the scans" in checks["drive forward"]["said"]
    assert "odometry reads" in checks["drive forward"]["said"]
