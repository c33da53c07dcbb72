"""A car only drives with a person's consent: new, restarted and second nodes, and the commands for them."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from rcl_interfaces.srv import GetParameters
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool

pytestmark = pytest.mark.dds

BUTTONS: list[Any] = []
"""Publishers of the emergency stop, destroyed after the test."""
CALM = ("-p", "scan_timeout:=1.0", "-p", "odom_timeout:=1.0", "-p", "pause_limit:=1.0", "-p", "speed_limit:=3.0")
"""Long timeouts, so that a busy machine does not stop the car."""
READY = "waiting for consent"


@pytest.fixture(scope="module")
def simulated(lab_of: Any) -> Iterator[Any]:
    """A simulator without a driver."""
    for lab in lab_of("consent"):
        lab.start_sim()
        yield lab


@pytest.fixture
def car(simulated: Any) -> Iterator[Any]:
    """The simulated car at its start; driving nodes are ended after the test."""
    assert simulated.probe.trigger("/reset").success
    before = list(simulated.running)
    yield simulated
    while BUTTONS:
        simulated.probe.node.destroy_publisher(BUTTONS.pop())
    for one in [one for one in simulated.running if one not in before]:
        one.end()
        simulated.running.remove(one)


def button(lab: Any, durability: DurabilityPolicy) -> Any:
    """A publisher of the emergency stop; warnings about incompatible QoS are suppressed."""
    qos = QoSProfile(depth=1, durability=durability)
    quiet = PublisherEventCallbacks(use_default_callbacks=False)
    BUTTONS.append(lab.probe.node.create_publisher(Bool, "/emergency_stop", qos, event_callbacks=quiet))
    return BUTTONS[-1]


def drive(lab: Any, *arguments: str) -> Any:
    """Starts a driving node like a user."""
    return lab.start("drive", *arguments, "--ros-args", *CALM)


def word(lab: Any, *arguments: str) -> tuple[int | None, str]:
    """Exit code and output of a command, with time to find the node."""
    running = lab.start(*arguments, "--wait", "30")
    lab.until(lambda: running.over, "its end")
    return running.wait(), running.output.strip()


def refused(lab: Any) -> bool:
    """Whether consent is refused because of the emergency stop."""
    return word(lab, "go")[1].startswith("error: emergency stop: release it first")


def let_go(lab: Any, *arguments: str) -> None:
    """Gives consent by the command, again until the node has its scans and its odometry."""
    said: list[str] = []

    def gone() -> bool:
        code, output = word(lab, "go", *arguments)
        assert code in (0, 1), output
        said.append(output)
        return code == 0

    lab.until(gone, lambda: f"consent is taken; the node said {said[-3:]}")
    assert said[-1].startswith("driving")
    lab.driving()


def stands(lab: Any, commands: int = 0) -> None:
    """Asserts that no command moves the car for a while."""
    heard = lab.probe.commands["/drive"]
    before = len(heard)
    for _ in range(150):
        lab.probe.spin(0.02)
    assert all(one.speed == 0.0 for one in heard[before:])
    assert len(heard) >= before + commands


def test_a_node_that_was_started_waits_for_a_person_and_says_its_speed_limit(car: Any) -> None:
    node = drive(car)
    car.until(lambda: READY in node.output, "it says so")
    assert "no command is faster than 3 m/s" in node.output
    stands(car)
    assert "]: driving:" not in node.output
    let_go(car)
    assert "driving: setup sure, at most 3 m/s" in node.output
    assert max(one.speed for one in car.probe.commands["/drive"][-50:]) <= 3.0 + 1e-6


def test_a_node_that_died_and_comes_back_waits_for_a_person_though_it_was_told_to_go(car: Any) -> None:
    node = drive(car, "--go")
    car.driving()
    node.send(signal.SIGKILL)
    node.wait()
    back = drive(car, "--go")
    car.until(lambda: "the previous node died while it drove" in back.output, "it says so")
    stands(car)
    let_go(car)


@pytest.mark.parametrize("durability", [DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL])
def test_an_emergency_stop_outlives_the_node_whoever_pressed_it(car: Any, durability: DurabilityPolicy) -> None:
    pressed = button(car, durability)
    node = drive(car, "--go")
    car.driving()
    car.until(lambda: pressed.get_subscription_count() > 0, "it is heard")
    pressed.publish(Bool(data=True))
    car.until(lambda: car.probe.speed() == 0.0, "a stop")
    car.stays_stopped(10)
    node.send(signal.SIGKILL)
    node.wait()
    if durability == DurabilityPolicy.VOLATILE:
        car.probe.node.destroy_publisher(BUTTONS.pop())  # no publisher repeats it
    back = drive(car, "--go")
    car.until(lambda: "an emergency stop was pressed before it drove" in back.output, "it says so")
    stands(car)
    car.until(lambda: refused(car), "consent is refused")
    if durability == DurabilityPolicy.TRANSIENT_LOCAL:
        pressed.publish(Bool(data=False))
    let_go(car, "--release")


def test_a_latched_release_of_the_past_takes_no_stop_away(car: Any) -> None:
    button(car, DurabilityPolicy.TRANSIENT_LOCAL).publish(Bool(data=False))
    new = button(car, DurabilityPolicy.VOLATILE)
    node = drive(car)
    car.until(lambda: READY in node.output and new.get_subscription_count() > 0, "it listens")

    def known() -> bool:
        new.publish(Bool(data=True))  # again: the node may not have matched the publisher yet
        return refused(car)

    car.until(known, "the stop is known")
    node.send(signal.SIGKILL)
    node.wait()
    back = drive(car)
    car.until(lambda: "an emergency stop was pressed" in back.output, "it is known still")
    car.until(
        lambda: refused(car),
        "the old release does not count",
    )
    let_go(car, "--release")


def test_the_words_of_the_command_line_stop_resume_and_set(car: Any) -> None:
    node = drive(car)
    car.until(lambda: READY in node.output, "it waits")
    code, output = word(car, "resume")
    assert code == 1
    assert "activate it, or call ~/go" in output
    let_go(car)
    assert word(car, "stop") == (0, "stopped")
    assert car.probe.speed() == 0.0
    assert word(car, "resume") == (0, "driving")
    car.driving()
    code, output = word(car, "stop", "--emergency")
    assert code == 0
    car.until(lambda: car.probe.speed() == 0.0, "a stop")
    code, output = word(car, "resume")
    assert code == 1
    assert output.startswith("error: emergency stop: release it first")
    assert word(car, "resume", "--release") == (0, "driving")
    assert word(car, "set", "v_max", "4") == (0, "velocity_profile.v_max: 4.0, was 5.0")
    request = GetParameters.Request(names=["velocity_profile.v_max"])
    got = car.probe.call(GetParameters, "/firstlap_drive/get_parameters", request).values
    assert got[0].double_value == 4.0


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("speed_limit", "99", "range"),
        ("v_max", "0.5", "v_min"),
        ("v_max", "fast", "velocity_profile.v_max is a number, not 'fast'"),
        ("laser_from_tf", "3", "laser_from_tf is true or false"),
        ("v_maks", "3", "did you mean v_max?"),
        ("drive_topic", "other", "read-only"),
    ],
)
def test_a_value_that_is_refused_is_one_line_and_exit_code_2(car: Any, name: str, value: str, reason: str) -> None:
    drive(car)
    code, output = word(car, "set", name, value)
    assert code == 2
    assert re.fullmatch("error: .*", output), output
    assert reason in output


@pytest.mark.parametrize("words", [("go",), ("resume",), ("stop",), ("stop", "--emergency"), ("set", "v_max", "3")])
def test_where_no_node_is_that_is_one_line_and_exit_code_3(car: Any, words: tuple[str, ...]) -> None:
    running = car.start(*words, "--wait", "0.5", "--namespace", "nobody")
    car.until(lambda: running.over, "its end")
    output = running.output.strip()
    assert (running.wait(), output.count("\n")) == (3, 0), output
    assert output.startswith("error: no driving node /nobody/firstlap_drive within 0.5 s")


def test_of_two_nodes_on_one_topic_the_second_does_not_drive_and_names_the_first(car: Any) -> None:
    first = drive(car, "--go")
    car.driving()
    second = car.start("drive", "--go", "--ros-args", *CALM, "-r", "__node:=other_drive")
    car.until(lambda: "another driving node drives: /firstlap_drive, process" in second.output, "it names the first")
    assert f"process {first.process.pid} on " in second.output
    assert not car.probe.trigger("/other_drive/go").success
    assert "]: driving:" not in second.output
    assert "stopped:" not in first.output
    first.send(signal.SIGTERM)
    first.wait()
    car.until(lambda: "]: driving:" in second.output, "the second drives when it is alone")


def test_of_two_nodes_that_start_at_the_same_moment_one_drives(car: Any) -> None:
    both = [drive(car, "--go"), car.start("drive", "--go", "--ros-args", *CALM, "-r", "__node:=other_drive")]
    gave_way = lambda: [one for one in both if "another driving node" in one.output]  # noqa: E731
    car.until(lambda: len(gave_way()) == 1 and car.probe.moves(), "one gives way, and one drives")
    (second,) = gave_way()
    (first,) = [one for one in both if one is not second]
    output = len(first.output)
    for _ in range(150):
        car.probe.spin(0.02)
    assert "]: driving:" in first.output
    assert "stopped:" not in first.output[output:]
    assert second.output.count("]: driving:") == second.output.count("stopped: another driving node")


def test_the_button_of_a_joystick_must_be_held_and_a_new_press_is_consent(car: Any) -> None:
    """A joystick as in f1tenth_system: 20 Hz, button 5."""
    held = [False]
    joy = car.probe.node.create_publisher(Joy, "/joy", 10)
    timer = car.probe.node.create_timer(0.05, lambda: joy.publish(Joy(buttons=[0, 0, 0, 0, 0, int(held[0]), 0])))
    asked = ("-p", "deadman_topic:=joy", "-p", "deadman_button:=5", "-p", "deadman_timeout:=1.0")
    node = car.start("drive", "--go", "--ros-args", *CALM, *asked)
    car.until(lambda: "not driving: dead-man released" in node.output, "it waits for the hand")
    for _attempt in range(2):
        held[0] = True
        car.driving()
        held[0] = False
        car.until(lambda: car.probe.speed() == 0.0, "a stop")
        stands(car, 10)
        assert "stopped: dead-man released" in node.output
    car.probe.node.destroy_timer(timer)
    held[0] = True
    stands(car, 10)
    car.probe.node.destroy_publisher(joy)
