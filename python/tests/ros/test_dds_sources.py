"""A car with poor odometry, an IMU, a measured steering angle and a dead-man's switch: each may fail."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

pytestmark = pytest.mark.dds

ARGUMENTS = (
    *("deadman_topic:=deadman", "deadman_timeout:=0.2", "imu_topic:=sensors/imu/raw", "steering_topic:=joint_states"),
    *("state_estimate.enabled:=true", "state_estimate.speed_sigma:=0.3", "state_estimate.yaw_rate_sigma:=0.3"),
    *("speed_limit:=3.0",),
)


class Button:
    """Publishes while the probe spins. held: None for no messages."""

    def __init__(self, lab: Any) -> None:
        self.held: bool | None = False
        self.publisher = lab.probe.node.create_publisher(Bool, "/deadman", 1)
        lab.probe.node.create_timer(0.02, self.publish)

    def publish(self) -> None:
        """The state of the dead-man's switch."""
        if self.held is not None:
            self.publisher.publish(Bool(data=self.held))


@pytest.fixture(scope="module")
def held(lab_of: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, Button]]:
    """A lab with such a car, and its dead-man's switch."""
    poor = Path(tmp_path_factory.mktemp("car")) / "poor.yaml"
    poor.write_text("sensors: {speed_noise: 0.3, yaw_rate_noise: 0.3, yaw_rate_bias: 0.2}\n")
    for lab in lab_of("sources"):
        lab.start_sim("arena", "--car", str(poor))
        button = Button(lab)
        lab.start_drive("--ros-args", *(text for one in ARGUMENTS for text in ("-p", one)))
        yield lab, button


def press(lab: Any, button: Button) -> None:
    """Presses the switch again until the car drives. After a release that is sufficient consent; after stops by a busy
    machine, consent is also given by the service."""

    def drives() -> bool:
        if lab.probe.moves():
            return True
        button.held = False
        for _ in range(5):
            lab.probe.spin(0.02)
        button.held = True
        for _ in range(25):
            lab.probe.spin(0.02)
        _, stopped, why = lab.drive.output.rpartition("stopped: ")
        if stopped and not lab.probe.moves() and not why.startswith(("dead-man", "no deadman")):
            lab.probe.trigger("/firstlap_drive/resume")
        return bool(lab.probe.moves())

    lab.until(drives, "drives when pressed anew")


def test_a_car_with_poor_odometry_drives_by_the_state_estimate(held: Any) -> None:
    lab, button = held
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    press(lab, button)
    driven = 0.0
    seen = 0

    def far() -> bool:
        nonlocal driven, seen
        for before, after in zip(truth[max(seen - 1, 0) :], truth[max(seen, 1) :], strict=False):
            a, b = before.pose.pose.position, after.pose.pose.position
            driven += math.hypot(b.x - a.x, b.y - a.y)
        seen = len(truth)
        if not lab.probe.moves():
            press(lab, button)
        return driven > 25.0

    lab.until(far, "half a lap", 120.0)
    assert "contact" not in lab.sim.output


def test_a_dead_man_button_stops_when_released_and_drives_when_pressed_anew(held: Any) -> None:
    lab, button = held
    press(lab, button)

    def release() -> None:
        button.held = False
        button.publish()

    lab.stops_in_time(release, known=True)
    lab.stays_stopped(15)
    press(lab, button)


def test_a_silent_dead_man_button_stops_and_one_that_was_held_through_the_silence_is_no_consent(held: Any) -> None:
    lab, button = held
    press(lab, button)

    def silence() -> None:
        button.held = None

    lab.stops_in_time(silence)
    button.held = True
    lab.stays_stopped(30)
    press(lab, button)


@pytest.mark.parametrize(
    ("fault", "reason"),
    [("drop_imu", "no imu for"), ("nan_imu", "not finite"), ("drop_steering", "no steering for")],
)
def test_an_imu_or_a_wheel_angle_that_fails_stops_the_car_until_the_driver_consents(
    held: Any, fault: str, reason: str
) -> None:
    lab, button = held
    wrong, well = (True, False) if fault == "nan_imu" else (1.0, 0.0)
    for _attempt in range(5):
        press(lab, button)
        lab.stops_in_time(lambda: lab.probe.set("/firstlap_sim", **{fault: wrong}))
        lab.stays_stopped(15)
        assert not lab.probe.trigger("/firstlap_drive/resume").success, "consent while the fault lasts"
        lab.probe.set("/firstlap_sim", **{fault: well})
        lab.stays_stopped(25)
        if reason in (output := lab.drive.output.rpartition("stopped: ")[2]):
            break
    assert reason in output
    lab.resume()
