"""Laps timed by poses alone."""

from __future__ import annotations

import math

import pytest

from firstlap.pitwall.laps import LapBook

RADIUS = 3.0
PERIOD = 0.025
ROUND = 2.0 * math.pi * RADIUS


def drive(book: LapBook, meters: float, speed: float = 3.0, start: float = 0.0, time: float = 0.0) -> float:
    """Drives along a circle around the origin from an arc length on; returns the end time."""
    steps = round(meters / (speed * PERIOD))
    for i in range(steps + 1):
        angle = (start + i * speed * PERIOD) / RADIUS
        x, y = RADIUS * math.cos(angle), RADIUS * math.sin(angle)
        book.add(time + i * PERIOD, (x, y, angle + 0.5 * math.pi), speed)
    return time + steps * PERIOD


def stand(book: LapBook, time: float = -1.0) -> None:
    """Stands still at the start for a second."""
    for i in range(40):
        book.add(time + i * PERIOD, (RADIUS, 0.0, 0.5 * math.pi), 0.0)


def test_laps_begin_where_the_car_began_to_drive_and_are_timed_between_poses() -> None:
    book = LapBook()
    stand(book)
    drive(book, 3.2 * ROUND)
    assert [lap.number for lap in book.laps] == [1, 2, 3]
    assert [lap.standing for lap in book.laps] == [True, False, False]
    assert book.laps[1].time == pytest.approx(ROUND / 3.0, abs=1e-3), "finer than a period"
    assert book.laps[0].time == pytest.approx(ROUND / 3.0, abs=1.5 * PERIOD)
    line = book.laps[1].line
    assert line.shape == (len(book.laps[1].speed), 2)
    assert math.hypot(*(line[0] - line[-1])) < 0.02, "it closes"


def test_the_smallest_clearance_is_of_its_own_lap() -> None:
    book = LapBook()
    stand(book)
    time = drive(book, 0.5 * ROUND)
    book.near(0.4)
    book.near(0.9)
    time = drive(book, 0.6 * ROUND, start=0.5 * ROUND, time=time)
    assert book.clearance is None
    book.near(0.7)
    drive(book, 1.0 * ROUND, start=1.1 * ROUND, time=time)
    assert [lap.clearance for lap in book.laps] == [0.4, 0.7]


def test_the_wrong_way_far_beside_the_line_or_after_too_short_a_way_is_no_lap() -> None:
    book = LapBook()
    stand(book)
    for i in range(20):  # across the line, back, and across it again
        y = 0.5 * math.sin(i)
        book.add(i * PERIOD, (RADIUS, y, 0.5 * math.pi), 1.0)
    assert book.laps == ()
    book = LapBook()
    stand(book)
    time = drive(book, 0.9 * ROUND)
    for i in range(80):  # passes 3 m outside
        book.add(time + i * PERIOD, (RADIUS + 3.0, -2.0 + 0.1 * i, 0.5 * math.pi), 4.0)
    assert book.laps == ()
    book = LapBook()
    stand(book)
    time = drive(book, 0.9 * ROUND)
    for i in range(80):  # rolls backward across it, facing the other direction
        book.add(time + i * PERIOD, (RADIUS, -2.0 + 0.1 * i, -0.5 * math.pi), 4.0)
    assert book.laps == ()


def test_a_gap_loses_the_lap_and_the_next_crossing_begins_one() -> None:
    book = LapBook()
    stand(book)
    time = drive(book, 0.5 * ROUND)
    drive(book, 2.2 * ROUND, start=0.7 * ROUND, time=time + 2.0)
    assert [(lap.number, lap.standing) for lap in book.laps] == [(1, False)]
    assert book.laps[0].time == pytest.approx(ROUND / 3.0, abs=1e-3)


def test_a_car_that_is_put_back_begins_a_lap_at_rest() -> None:
    book = LapBook()
    stand(book)
    time = drive(book, 1.5 * ROUND)
    stand(book, time + PERIOD)
    drive(book, 1.1 * ROUND, time=time + 41 * PERIOD)
    assert [(lap.number, lap.standing) for lap in book.laps] == [(1, True), (2, True)]
    assert book.laps[1].time == pytest.approx(ROUND / 3.0, abs=1.5 * PERIOD)


def test_a_clock_that_goes_back_is_no_lap_of_negative_time() -> None:
    book = LapBook()
    stand(book)
    drive(book, 0.5 * ROUND)
    drive(book, 0.6 * ROUND, start=0.5 * ROUND, time=-50.0)
    assert book.laps == ()
