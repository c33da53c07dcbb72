"""Traces of all drivers as standard messages, without ROS: round trips, and lost, late and invalid messages."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import firstlap
from firstlap.config.car_file import load_car
from firstlap.config.driver_kind import DRIVERS, Preparation
from firstlap.config.setup_file import choose_setup
from firstlap.pitwall.ros_source import RosSource
from firstlap.recordings import log_messages as ros
from firstlap.recordings.messages import typestore
from firstlap.recordings.trace_tables import READ, TABLES, put
from firstlap.recordings.write import TOPICS
from firstlap.ros.trace_message import MAX_BYTES, STATUS, TraceHeader, messages_of, topics_of
from firstlap.ros.trace_reader import KEPT, TraceReader
from firstlap.sim.race import start_race

TOLD = TraceHeader("7-1", "local", 12.5, 3.0, 0.1, -0.2, 45.0, True, "")
LASER = (0.27, 0.0)
STEPS = (0, 1, 40, 160)
KNOWN = tuple(name for name, kind in DRIVERS.items() if not kind.needs_map)


def traces_of(driver: str) -> Iterator[Mapping[str, Any]]:
    """Traces before the first step on arena, and after some steps."""
    setup, car = choose_setup(driver, None), load_car("default")
    handle = DRIVERS[driver].make(setup.params(car.core), car, Preparation())
    race = start_race(firstlap.load_track("arena"), handle, car, laps=1)
    for steps in STEPS:
        race.advance(steps)
        yield handle.trace


@cache
def last_trace_of(driver: str) -> Mapping[str, Any]:
    """The last of these traces."""
    *_, last = traces_of(driver)
    return last


@pytest.fixture(scope="module")
def traces() -> dict[str, list[Mapping[str, Any]]]:
    """Traces of all drivers that need no map."""
    return {driver: list(traces_of(driver)) for driver in KNOWN}


def messages(told: TraceHeader, trace: Mapping[str, Any], frame: str = "base_link") -> list[tuple[str, Any]]:
    """All messages of a step, as received by a subscriber."""
    types = topics_of(told.driver)
    sent = messages_of(told, trace, frame, LASER, set(types))
    return [(name, typestore().deserialize_cdr(data, types[name])) for name, data in sent]


def hear(reader: TraceReader, name: str, message: Any) -> Any:
    """Passes a message of the topic `name` to the reader, if it is a status or a table."""
    return reader.add(name, message) if name == STATUS or hasattr(message, "point_step") else None


def read(parts: list[tuple[str, Any]]) -> Any:
    """The step from its messages."""
    reader = TraceReader()
    (step,) = [step for step in (hear(reader, *part) for part in parts) if step]
    return step


def same(sent: Any, got: Any) -> None:
    """Asserts equality: 32-bit precision in arrays, exact elsewhere."""
    if isinstance(sent, Mapping):
        assert sent.keys() == got.keys()
        for name in sent:
            same(sent[name], got[name])
    elif isinstance(sent, (np.ndarray, list)):
        assert len(sent) == len(got)
        np.testing.assert_allclose(got, sent, rtol=1e-6, atol=1e-6)
    else:
        assert type(sent) is type(got)
        assert sent == got


@pytest.mark.parametrize("driver", KNOWN)
def test_every_drivers_trace_comes_back_as_it_was_sent(driver: str, traces: dict[str, Any]) -> None:
    told = replace(TOLD, driver=driver)
    for trace in traces[driver]:
        header, got = read(messages(told, trace))
        assert header == told
        same(trace, got)
    assert got["result"][2] == "ok"


NUMBERS = st.one_of(
    st.integers(-(10**18) + 1, 10**18 - 1), st.floats(allow_nan=False), st.booleans(), st.none(), st.just("ok")
)


@st.composite
def made_up(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    """A driver and a valid trace with arbitrary values."""
    driver = draw(st.sampled_from(sorted(TABLES)))
    trace: dict[str, Any] = {"first_beam": -2.0, "beam_step": 0.01, "step": 0.01, "result": (1.0, 0.5, "ok")}
    for table in TABLES[driver]:
        count = 0 if table.name == "disparities" else draw(st.integers(0, 5))
        for column in table.columns:
            if len(column.kinds) > 1:
                put(trace, column.source, [(i, 0.5 * i) for i in range(count)])
                continue
            shape = (count,) if len(column.fields) == 1 else (count, len(column.fields))
            values = draw(arrays.arrays(column.kinds[0], shape))
            if column.source not in _found(trace):
                put(trace, column.source, values.astype(READ[column.kinds[0]]))
    trace["more"] = draw(st.dictionaries(st.text("abc_", min_size=1), NUMBERS, min_size=1))
    return driver, trace


def _found(trace: Mapping[str, Any], path: str = "") -> set[str]:
    """Paths of all values in a trace."""
    found = set()
    for name, value in trace.items():
        found |= _found(value, f"{path}{name}.") if isinstance(value, dict) else {path + name}
    return found


@given(made_up())
@settings(deadline=None, max_examples=60)
def test_any_values_come_back_as_they_were_sent(step: tuple[str, dict[str, Any]]) -> None:
    driver, trace = step
    views = [table.name for table in TABLES[driver]]
    sent = messages_of(replace(TOLD, driver=driver), trace, "car1/base", LASER, {STATUS, *views})
    types = topics_of(driver)
    with np.errstate(all="ignore"):
        header, got = read([(name, typestore().deserialize_cdr(data, types[name])) for name, data in sent])
        assert header.driver == driver
        same(trace, got)


def test_a_stop_needs_no_trace() -> None:
    stop = replace(TOLD, going=False, said="no scan for 0.12 s")
    (part,) = messages(stop, {})
    assert read([part]) == (stop, {})
    assert [(one.name, one.message, one.level) for one in part[1].status] == [("firstlap", stop.said, ros.WARN)]


def test_the_status_says_what_the_log_says_and_lists_the_tables(traces: dict[str, Any]) -> None:
    trace = traces["local"][-1]
    parts = dict(messages(TOLD, trace, "car1/base"))
    step, numbers, tables = parts[STATUS].status
    logged = typestore().deserialize_cdr(ros.status(0, 0), ros.DIAGNOSTICS).status[0]
    assert (step.name, step.message, step.level, step.hardware_id) == (
        logged.name,
        logged.message,
        logged.level,
        logged.hardware_id,
    )
    assert {one.key: one.value for one in numbers.values}["width"] == repr(trace["width"])
    assert {one.key: one.value for one in tables.values} == {
        table.name: str(parts[table.name].width) for table in TABLES["local"]
    }
    stamps = {(one.header.stamp.sec, one.header.stamp.nanosec) for one in parts.values() if hasattr(one, "header")}
    assert stamps == {(12, 500_000_000)}
    assert {one.header.frame_id for one in parts.values() if hasattr(one, "header")} == {"car1/base"}


def test_what_the_log_holds_has_the_same_types_and_names() -> None:
    live, logged = topics_of("local"), {topic.rpartition("/")[2]: kind for topic, kind in TOPICS.items()}
    shared = {topic.rpartition("/")[2] for topic in TOPICS if topic.startswith("/firstlap/")}
    assert {name: live[name] for name in shared} == {name: logged[name] for name in shared}


def test_what_has_a_place_can_be_drawn(traces: dict[str, Any]) -> None:
    for driver in KNOWN:
        for name, message in messages(replace(TOLD, driver=driver), traces[driver][-1]):
            fields = [field.name for field in getattr(message, "fields", [])]
            assert "x" not in fields or fields[:3] == ["x", "y", "z"], name
    trace = traces["gap"][-1]
    beams = dict(messages(replace(TOLD, driver="gap"), trace))["beams"]
    x = np.frombuffer(beams.data, "<f4").reshape(beams.width, -1)[540, 0]
    assert x == pytest.approx(LASER[0] + trace["ranges"][540], rel=1e-5), "the beam ahead"


def test_ros_reads_the_bytes_of_every_topic(traces: dict[str, Any]) -> None:
    rclpy = pytest.importorskip("rclpy.serialization")
    classes = pytest.importorskip("firstlap.ros.traces").CLASSES
    for driver in KNOWN:
        types = topics_of(driver)
        sent = messages_of(replace(TOLD, driver=driver), traces[driver][-1], "base_link", LASER, set(types))
        for name, data in sent:
            again = rclpy.serialize_message(rclpy.deserialize_message(data, classes[types[name]]))
            plain = typestore().serialize_cdr(typestore().deserialize_cdr(again, types[name]), types[name])
            assert bytes(plain) == data, f"{name}, but for what is between its fields"


def test_only_what_is_wanted_is_made(traces: dict[str, Any]) -> None:
    sent = messages_of(TOLD, traces["local"][-1], "base_link", LASER, {"path", "points"})
    assert sorted(name for name, _ in sent) == ["path", "points"]


def test_what_cannot_be_sent_or_is_too_large_is_refused(traces: dict[str, Any]) -> None:
    trace = dict(traces["gap"][-1])
    gap = replace(TOLD, driver="gap")
    for wrong, why in (
        ({"free": np.zeros(MAX_BYTES)}, "too large"),
        ({"more": np.zeros(3)}, "cannot be sent"),
        ({"more": object()}, "cannot be sent"),
    ):
        with pytest.raises(ValueError, match=why):
            messages(gap, {**trace, **wrong})
    del trace["free"]
    with pytest.raises(ValueError, match="no free"):
        messages(gap, trace)


# Lost, late and out of order.


def test_messages_may_come_in_any_order(traces: dict[str, Any]) -> None:
    parts = messages(TOLD, traces["local"][-1])
    for seed in range(10):
        order = np.random.default_rng(seed).permutation(len(parts))
        same(traces["local"][-1], read([parts[i] for i in order])[1])


def test_a_step_of_which_something_is_lost_does_not_hold_up_the_next(traces: dict[str, Any]) -> None:
    reader = TraceReader()
    trace = traces["local"][-1]
    lost = [part for part in messages(TOLD, trace) if part[0] != "left"]
    assert not any(hear(reader, *part) for part in lost)
    steps = [hear(reader, *part) for part in messages(replace(TOLD, time=12.55), trace)]
    assert [step[0].time for step in steps if step] == [12.55]
    assert not any(hear(reader, *part) for part in messages(TOLD, trace) if part[0] == "left"), "too late"


def test_a_table_that_never_comes_is_said_and_nothing_grows(traces: dict[str, Any]) -> None:
    reader, trace = TraceReader(), traces["local"][-1]

    def error_of(name: str, message: Any) -> str:
        try:
            assert hear(reader, name, message) is None
        except ValueError as error:
            return str(error)
        finally:
            assert len(reader._steps) <= KEPT
        return ""

    for i in range(5 * KEPT):
        parts = messages(replace(TOLD, time=12.5 + 0.05 * i), trace)
        heard = {error_of(*part) for part in parts if part[0] != "left"}
        assert heard == ({"", "left of the step did not arrive"} if i >= KEPT else {""})


def test_a_nan_of_any_kind_stays_one(traces: dict[str, Any]) -> None:
    parts = messages(TOLD, traces["local"][-1])
    smoothed = dict(parts)["smoothed"]
    smoothed.data = np.array(smoothed.data)
    smoothed.data[:4] = np.frombuffer(np.uint32(0x7FA00000).tobytes(), np.uint8)  # a signaling NaN
    assert math.isnan(read(parts)[1]["smoothed"][0, 0])


# Invalid and malicious messages.

ODD = {
    "no data": lambda m: setattr(m, "data", np.zeros(0, np.uint8)),
    "a row less": lambda m: setattr(m, "width", m.width - 1),
    "rows without end": lambda m: (setattr(m, "width", 2**32 - 1), setattr(m, "height", 2**32 - 1)),
    "rows of nothing": lambda m: (setattr(m, "point_step", 0), setattr(m, "data", m.data[:0])),
    "a huge one": lambda m: setattr(m, "data", np.zeros(MAX_BYTES + 1, np.uint8)),
    "no fields": lambda m: setattr(m, "fields", []),
    "another name": lambda m: setattr(m.fields[0], "name", "X"),
    "another type": lambda m: setattr(m.fields[0], "datatype", 8),
    "a type that is none": lambda m: setattr(m.fields[0], "datatype", 77),
    "a field behind the row": lambda m: setattr(m.fields[0], "offset", 2**32 - 1),
    "several in one": lambda m: setattr(m.fields[0], "count", 2),
}


@pytest.mark.parametrize("odd", ODD)
def test_a_table_that_cannot_be_is_refused_in_one_line(odd: str, traces: dict[str, Any]) -> None:
    parts = messages(TOLD, traces["local"][-1])
    ODD[odd](dict(parts)["left"])
    reader = TraceReader()
    with pytest.raises(ValueError, match="left") as raised:
        for part in parts:
            hear(reader, *part)
    assert "\n" not in str(raised.value)


def test_a_table_may_be_packed_in_another_way(traces: dict[str, Any]) -> None:
    parts = messages(TOLD, traces["local"][-1])
    left = dict(parts)["left"]
    rows = np.frombuffer(left.data, "<f4").reshape(left.width, -1)
    left.data = np.frombuffer(np.column_stack([np.zeros(len(rows)), rows[:, ::-1]]).astype(">f4").tobytes(), np.uint8)
    left.is_bigendian, left.point_step = True, left.point_step + 4
    for i, field in enumerate(left.fields):
        field.offset = 4 * (rows.shape[1] - i)
    same(traces["local"][-1], read(parts)[1])


def _told(message: Any, **values: str | None) -> None:
    step = message.status[0]
    kept = [one for one in step.values if one.key not in values]
    step.values = kept + [
        ros.make("diagnostic_msgs/msg/KeyValue", name, value) for name, value in values.items() if value is not None
    ]


def _number(message: Any, name: str, value: str) -> None:
    message.status[1].values.append(ros.make("diagnostic_msgs/msg/KeyValue", name, value))


STRANGE = {
    "nothing": (lambda m: setattr(m, "status", []), "no entry of a step"),
    "another's": (lambda m: setattr(m.status[0], "name", "vesc"), "no entry of a step"),
    "no driver": (lambda m: _told(m, driver=None), "no valid driver"),
    "a speed of text": (lambda m: _told(m, speed="fast"), "no valid speed"),
    "a time that is none": (lambda m: _told(m, time="nan"), "no valid time"),
    "a time beyond all numbers": (lambda m: _told(m, time="9" * 400), "no valid time"),
    "perhaps going": (lambda m: _told(m, going="perhaps"), "no valid going"),
    "a speed of text in the result": (lambda m: _number(m, "result.speed", "fast"), "result"),
    "a result of four": (lambda m: _number(m, "result.more", "1"), "result"),
    "a number in a number": (lambda m: _number(m, "width.x", "1"), "is a number"),
    "an array as a number": (lambda m: _number(m, "left.points", "1"), "twice"),
    "a folder that is a table": (lambda m: _number(m, "samples.x", "1"), "twice"),
    "values without end": (lambda m: [_number(m, f"n{i}", "1") for i in range(1000)], "at most"),
}


@pytest.mark.parametrize("odd", STRANGE)
def test_a_status_that_cannot_be_is_refused_in_one_line(odd: str, traces: dict[str, Any]) -> None:
    change, why = STRANGE[odd]
    parts = messages(TOLD, traces["local"][-1])
    change(dict(parts)[STATUS])
    with pytest.raises(ValueError, match=why) as raised:
        read(parts)
    assert "\n" not in str(raised.value)


WORDS = st.one_of(st.text(max_size=20), st.sampled_from(["nan", "-inf", "none", "true", "1e999", "9" * 600, "a.b"]))


@st.composite
def broken(draw: st.DrawFn) -> tuple[str, int, list[Any]]:
    """A driver, one of its messages, and a change."""
    driver = draw(st.sampled_from(KNOWN))
    edits = st.tuples(st.integers(0, 8), st.integers(0, 2**32 - 1), WORDS)
    return driver, draw(st.integers(0, 20)), draw(st.lists(edits, min_size=1, max_size=4))


def spoil(message: Any, kind: int, number: int, word: str) -> None:
    """Changes something in a message."""
    if hasattr(message, "status"):
        one = message.status[number % len(message.status)]
        if not one.values or kind == 0:
            one.name = word
        elif kind == 1:
            one.values = one.values[: number % len(one.values)]
        elif kind == 2:
            one.values[number % len(one.values)].key = word
        else:
            one.values[number % len(one.values)].value = word
        return
    data = np.array(message.data)
    if kind < 3:
        setattr(message, ("width", "height", "point_step")[kind], number)
    elif kind < 6:
        setattr(message.fields[number % len(message.fields)], ("offset", "datatype", "count")[kind - 3], number % 9)
    elif kind == 6:
        message.fields[number % len(message.fields)].name = word
    elif kind == 7:
        data = data[: number % (len(data) + 1)]
    else:
        data[number % max(len(data), 1) :][:9] = 255
    message.data = data


@given(broken())
@example(("gap", 2, [(3, 1, "INF")]))
@settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])
def test_the_pit_wall_shows_any_broken_step_or_says_why_not(step: tuple[str, int, list[Any]]) -> None:
    driver, which, edits = step
    source = RosSource()
    parts = messages(replace(TOLD, driver=driver), last_trace_of(driver))
    taken = [part for part in parts if part[0] == STATUS or hasattr(part[1], "point_step")]
    for edit in edits:
        spoil(taken[which % len(taken)][1], *edit)
    for name, message in taken:
        source.on_trace(name, message)
    frame = source.latest()
    assert frame is None or math.isfinite(frame.time)
    assert "\n" not in source._bad_trace
