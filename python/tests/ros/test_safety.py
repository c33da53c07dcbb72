"""The watchdog alone: what stops the car, and that only consent ends a stop."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from firstlap.ros.clock_watch import ClockWatch
from firstlap.ros.safety import DeadMan, Stamps, Watchdog, button_of, within


def armed(**timeouts: float) -> Watchdog:
    """A watchdog fed and armed at 0 s."""
    watchdog = Watchdog(timeouts or {"scan": 0.1, "odom": 0.2})
    for source in watchdog.timeouts:
        watchdog.feed(source, 0.0)
    assert watchdog.arm(0.0) == ""
    return watchdog


def test_silence_of_a_source_stops_after_its_timeout_and_not_before() -> None:
    watchdog = armed()
    assert watchdog.check(0.1) == ""
    watchdog.feed("scan", 0.1)
    assert watchdog.check(0.2) == ""
    watchdog.feed("scan", 0.2)
    assert "no odom for 0.21 s" in watchdog.check(0.21)


def test_a_stop_stays_though_everything_is_well_again() -> None:
    watchdog = armed()
    assert watchdog.check(0.15)
    for i in range(100):
        now = 0.15 + 0.01 * i
        watchdog.feed("scan", now)
        watchdog.feed("odom", now)
        assert watchdog.check(now) == "no scan for 0.15 s"
    assert watchdog.arm(1.2) == ""
    assert watchdog.check(1.21) == ""


def test_consent_is_refused_while_a_source_is_silent() -> None:
    watchdog = Watchdog({"scan": 0.1})
    assert watchdog.arm(0.0) == "no scan yet"
    watchdog.feed("scan", 0.0)
    watchdog.reject("scan", "7 beams")
    assert watchdog.arm(0.5) == "no scan for 0.50 s (7 beams)"
    assert not watchdog.armed


def test_a_node_that_did_not_run_for_a_while_does_not_drive_on() -> None:
    watchdog = armed(scan=10.0)
    assert watchdog.check(0.1) == ""
    watchdog.feed("scan", 1.0)
    assert watchdog.check(1.0) == "the node did not run for 0.90 s"


def test_a_pause_is_seen_though_the_simulated_clock_stood_still_too() -> None:
    watchdog = armed()
    assert watchdog.check(0.0, 5.0) == ""
    assert watchdog.check(0.0, 5.5) == "the node did not run for 0.50 s"


def test_a_simulated_clock_that_stands_still_for_too_long_is_told_and_asking_changes_nothing() -> None:
    clock = ClockWatch(0.25)
    assert clock.reason(9.0) == "", "nobody looked yet"
    for now, steady in ((1.0, 10.0), (1.1, 10.1), (1.1, 10.3)):
        clock.update(now, steady)
    assert clock.reason(10.35) == ""
    assert clock.reason(10.4) == clock.reason(10.4) == "/clock has not advanced for 0.30 s"
    clock.update(1.2, 10.4)
    assert clock.reason(10.4) == ""


def test_a_rejected_message_is_counted_and_does_not_feed() -> None:
    watchdog = armed()
    for i in range(20):
        watchdog.reject("scan", "100 % of it is NaN")
        watchdog.check(0.01 * i)
    assert watchdog.tripped.endswith("(100 % of it is NaN)")
    assert watchdog.faults["scan rejected"] == 20


def test_a_dead_man_button_drives_on_only_when_pressed_anew() -> None:
    button = DeadMan()
    assert button.press(True, True)
    assert not button.press(True, True)
    assert not button.press(False, True)
    assert button.press(True, True)
    assert not button.press(True, False), "after lost messages a held button is not a new press"
    assert not button.press(False, True)
    assert button.press(True, True)


def test_stamps_that_go_back_repeat_or_are_old_are_refused() -> None:
    stamps = Stamps(0.15)
    assert stamps.reason(10.0, 10.05) == stamps.reason(10.0, 10.05) == "", "a question changes nothing"
    stamps.take(10.0)
    assert "before the last" in stamps.reason(9.9, 10.06)
    assert "same stamp" in stamps.reason(10.0, 10.06)
    assert "old" in stamps.reason(10.1, 10.4)
    assert "future" in stamps.reason(11.0, 10.4)
    assert stamps.reason(10.35, 10.4) == ""
    assert Stamps(0.0).reason(10.0, 99.0) == ""


def test_a_stamp_may_be_of_the_first_moment_of_a_long_sweep_or_of_its_last() -> None:
    for stamp in (10.0, 9.8):
        assert Stamps(0.15).reason(stamp, 10.01, 0.2) == ""
    assert "old" in Stamps(0.15).reason(9.6, 10.01, 0.2)
    assert "future" in Stamps(0.15).reason(10.2, 10.01, 0.2)


def test_a_button_of_a_joystick_is_held_as_a_bool_is() -> None:
    joy = SimpleNamespace(buttons=[0, 0, 0, 0, 0, 1])
    assert button_of(joy, 5) == (True, "")
    assert button_of(joy, 4) == (False, "")
    assert button_of(joy, 6) == (False, "no button 6 among 6")
    assert button_of(SimpleNamespace(data=True), -1) == (True, "")


@pytest.mark.parametrize("speed", [0.0, 1e-3, 0.5, 99.0])
def test_commands_are_held_within_limits_and_a_stop_stays_a_stop(speed: float) -> None:
    found = within(speed, -2.0, 5.0, 0.4)
    assert found == (min(speed, 5.0), -0.4)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_none(bad: float) -> None:
    assert within(bad, 0.0, 5.0, 0.4) is None
    assert within(1.0, bad, 5.0, 0.4) is None


def test_a_node_that_ends_stops_the_car_before_it_waits_for_its_thread() -> None:
    pytest.importorskip("rclpy")
    from firstlap.ros.drive_node import DriveNode

    did: list[str] = []
    node = SimpleNamespace(
        active=True,
        stops_left=0,
        watchdog=armed(),
        watch=SimpleNamespace(stop=lambda: did.append("waits for the thread")),
        publish_stop=lambda: did.append("stop"),
        emergency=SimpleNamespace(drives=lambda drives: None),
        other_drivers=SimpleNamespace(claim=lambda drives: None),
        drive=SimpleNamespace(wait_for_all_acked=lambda timeout: None),
    )
    DriveNode.halt(node)  # type: ignore[arg-type]
    assert did == ["stop", "stop", "stop", "waits for the thread"]
    did.clear()
    DriveNode.halt(node)  # type: ignore[arg-type]
    assert did == ["waits for the thread"], "the topic is left to others"
