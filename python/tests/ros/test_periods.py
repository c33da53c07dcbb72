"""Timeouts of sources by their measured periods."""

from __future__ import annotations

import pytest

from firstlap.ros.periods import BOUNDS, KEPT, Bounds, Period, rate_reason, timeout_of


def heard(*stamps: float) -> Period:
    """A period of these stamps."""
    period = Period()
    for stamp in stamps:
        period.add(stamp)
    return period


def test_a_period_is_the_median_of_its_steps_and_not_known_from_one() -> None:
    assert heard(1.0).seconds == heard(1.0, 1.1).seconds == 0.0
    assert heard(1.0, 1.1, 1.2, 1.3).seconds == pytest.approx(0.1)
    lossy = [0.1 * i for i in range(40) if i % 4]
    assert heard(*lossy).seconds == pytest.approx(0.1), "one message in four is lost"
    faster = [0.1 * i for i in range(10)] + [0.9 + 0.025 * i for i in range(1, KEPT + 1)]
    assert heard(*faster).seconds == pytest.approx(0.025)


def test_a_step_is_the_time_since_the_last_stamp_and_none_at_first_or_after_a_new_beginning() -> None:
    period = Period()
    assert period.add(5.0) == 0.0
    assert period.add(5.2) == pytest.approx(0.2)
    assert period.add(5.1) == 0.0
    period.forget()
    assert (period.add(99.0), period.seconds) == (0.0, 0.0)


@pytest.mark.parametrize("rate", [5.0, 5.5, 7.0, 8.0, 10.0, 15.0, 20.0, 40.0, 100.0])
def test_every_lidar_that_people_have_may_lose_a_scan_and_jitter(rate: float) -> None:
    timeout = timeout_of(0.0, 1.0 / rate, BOUNDS["scan"])
    assert 2.49 / rate <= timeout <= 0.5 or timeout == BOUNDS["scan"].least
    assert rate_reason("scan", 1.0 / rate, timeout) == ""


def test_a_timeout_is_bounded_and_somebody_may_say_another() -> None:
    bounds = Bounds(0.1, 0.5)
    assert timeout_of(0.0, 0.025, bounds) == 0.1
    assert timeout_of(0.0, 0.1, bounds) == pytest.approx(0.25)
    assert timeout_of(0.0, 2.0, bounds) == 0.5
    assert timeout_of(0.0, 0.0, bounds) == 0.5, "not known yet"
    assert timeout_of(0.3, 0.025, bounds) == 0.3


def test_a_source_that_is_too_slow_for_its_timeout_is_named_with_the_rate_it_needs() -> None:
    assert rate_reason("scan", 0.5, 0.5) == "scan at 2.0 Hz; with a timeout of 0.5 s it needs 3.0 Hz"
    assert rate_reason("scan", 0.0, 0.5) == "too few messages of scan yet to measure its rate"
