"""The trace of a driver's step as standard messages: a DiagnosticArray with its numbers, and a PointCloud2 per table.

All messages have the stamp of the step. The status lists the tables, so that a reader knows when a step is complete.
Tables have 32-bit floats, for display. Nothing here needs ROS.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstlap.recordings import log_messages as ros
from firstlap.recordings.log_messages import Diagnosis
from firstlap.recordings.trace_tables import TABLES
from firstlap.ros.conversions import nanoseconds
from firstlap.ros.trace_views import VIEWS

TRACE, STATUS = "trace", "status"
"""Prefix of the trace topics, and the topic with the status of a step."""
NUMBERS, LISTED = f"{ros.HARDWARE}/numbers", f"{ros.HARDWARE}/tables"
"""Names of further entries in the status: the trace without its arrays, and the number of rows of each table."""
MAX_BYTES = 1_000_000
"""Maximum size of a table; larger ones are neither sent nor read."""
MAX_VALUES = 500
"""Maximum number of values in a status."""
MAX_TEXT = 500
SEQUENCES: dict[str, tuple[str, ...]] = {
    "result": ("speed", "steering_angle", "status"),
    "run": ("first", "last"),
    "block": ("first", "last"),
    "nearest": ("x", "y"),
    "pose": ("x", "y", "yaw"),
}
"""Tuples in a trace, and the names of their items in the message."""
WORDS = {"true": True, "false": False, "none": None}


ARRAYS = {
    driver: frozenset(column.source for table in tables for column in table.columns)
    for driver, tables in TABLES.items()
}
"""Driver -> parts of its trace that are in a table."""


@dataclass(frozen=True)
class TraceHeader:
    """The header of a trace. Its fields are keys of the message. born: identifies the run of the node. time: end of the
    scan [s], or now while stopped. speed [m/s], yaw_rate [rad/s], steering_angle [rad]: the driver's input. step_us:
    compute time [us]. going: whether the car may move. said: why not. sent_speed [m/s], sent_angle [rad]: the published
    command."""

    born: str
    driver: str
    time: float
    speed: float
    yaw_rate: float
    steering_angle: float
    step_us: float
    going: bool
    said: str
    sent_speed: float = 0.0
    sent_angle: float = 0.0


def topics_of(driver: str) -> dict[str, str]:
    """The topics of a driver's trace: name under TRACE -> message type."""
    views = {name: view.kind for name, view in VIEWS.get(driver, {}).items()}
    return {STATUS: ros.DIAGNOSTICS, **{table.name: ros.CLOUD for table in TABLES.get(driver, ())}, **views}


def messages_of(
    header: TraceHeader, trace: Mapping[str, Any], frame: str, laser: tuple[float, float], wanted: set[str]
) -> Iterator[tuple[str, bytes]]:
    """Name and bytes of each wanted message, the status last. laser: its x, y [m]. An empty trace only has a status.
    Raises ValueError for a message that is too large or has unsupported content."""
    now = nanoseconds(header.time)
    listed = {}
    for table in TABLES.get(header.driver, ()) if trace else ():
        if wanted.isdisjoint((table.name, STATUS)):
            continue
        rows = table.rows(trace, laser)
        listed[table.name] = str(len(rows))
        if rows.nbytes > MAX_BYTES:
            raise ValueError(f"{table.name} of {rows.nbytes} bytes is too large to be sent")
        if table.name in wanted:
            yield table.name, ros.cloud(now, rows, frame)
    for name, view in VIEWS.get(header.driver, {}).items() if trace else ():
        if name in wanted:
            for message in view.made(trace, now, header.step_us, frame):
                yield name, message
    if STATUS in wanted:
        yield STATUS, _status(header, trace, now, frame, listed)


def _status(header: TraceHeader, trace: Mapping[str, Any], now: int, frame: str, listed: Mapping[str, str]) -> bytes:
    values = {name: _text(value) for name, value in vars(header).items()}
    if not trace:
        return ros.diagnostics(now, [Diagnosis(ros.HARDWARE, header.said, ros.WARN, values)], frame)
    numbers = dict(_numbers(trace, "", ARRAYS.get(header.driver, frozenset())))
    if len(numbers) > MAX_VALUES:
        raise ValueError(f"{len(numbers)} numbers are too many to be sent")
    about = [
        ros.diagnosis(numbers.get("result.status", ""), values),
        Diagnosis(NUMBERS, f"{len(numbers)} values", values=numbers),
        Diagnosis(LISTED, f"{len(listed)} tables", values=listed),
    ]
    return ros.diagnostics(now, about, frame)


def _numbers(trace: Mapping[str, Any], path: str, arrays: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Path and text of everything that is not in a table."""
    for name, value in trace.items():
        place = path + name
        if place in arrays:
            continue
        items = SEQUENCES.get(place) if type(value) is tuple else None
        if items is not None and len(items) == len(value):
            value = dict(zip(items, value, strict=True))
        if isinstance(value, dict):
            yield from _numbers(value, f"{place}.", arrays)
        else:
            yield place, _text(value)


def _text(value: object) -> str:
    """The value as text, with full precision."""
    if value is None or isinstance(value, bool):
        return "none" if value is None else "true" if value else "false"
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, str):
        return value[:MAX_TEXT]
    raise ValueError(f"{type(value).__name__} {str(value)[:40]!r} cannot be sent")
