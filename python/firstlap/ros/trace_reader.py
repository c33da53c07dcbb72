"""Assembles the steps of a driving node from their messages, which may arrive in any order, get lost, or be invalid:
only ValueError is raised. Messages are duck-typed; nothing here needs ROS."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from firstlap.recordings.log_messages import HARDWARE, POINT_TYPES
from firstlap.recordings.trace_tables import TABLES, Rows, Table, put
from firstlap.ros.trace_message import (
    LISTED,
    MAX_BYTES,
    MAX_TEXT,
    MAX_VALUES,
    NUMBERS,
    SEQUENCES,
    STATUS,
    WORDS,
    TraceHeader,
)

TYPES = {kind: np.dtype(name) for name, kind in POINT_TYPES.items()}
INTEGER = re.compile(r"-?[0-9]{1,18}")
"""An integer that fits into 64 bits; longer ones are read as floats."""
KEPT = 5
"""Maximum number of incomplete steps; the oldest are dropped."""

Stamp = tuple[int, int]
Trace = dict[str, Any]


@dataclass(frozen=True)
class TraceStatus:
    """The status of one step. listed: its tables."""

    header: TraceHeader
    numbers: dict[str, str]
    listed: tuple[Table, ...]

    def trace(self, messages: Mapping[str, Any]) -> Trace:
        """The trace, from the messages of its tables by name. Raises ValueError."""
        trace: Trace = {}
        for name, text in self.numbers.items():
            put(trace, name, _value(text))
        for table in self.listed:
            table.put(trace, read_table(table, messages[table.name]))
        for name, items in SEQUENCES.items():
            if isinstance(trace.get(name), dict):
                trace[name] = _sequence(name, items, trace[name])
        return trace


def read_status(message: Any) -> TraceStatus:
    """Reads a DiagnosticArray. Raises ValueError."""
    about = {one.name: one for one in message.status[:MAX_VALUES]}
    if HARDWARE not in about:
        raise ValueError("the status has no entry of a step")
    header = _header(_values(about[HARDWARE]))
    numbers, listed = (_values(about[name]) if name in about else {} for name in (NUMBERS, LISTED))
    tables = tuple(table for table in TABLES.get(header.driver, ()) if table.name in listed)
    return TraceStatus(header, numbers, tables)


def read_table(table: Table, message: Any) -> Rows:
    """Reads a PointCloud2, with fields in any order and possibly further ones. Raises ValueError."""
    count, size, data = message.width * message.height, message.point_step, memoryview(message.data)
    if size < 1 or not count * size == data.nbytes <= MAX_BYTES:
        raise ValueError(f"{table.name} has {data.nbytes} bytes; expected {count} rows of {size} bytes")
    found = {field.name: field for field in message.fields if field.count == 1}
    for name, kind in _columns(table):
        field = found.get(name)
        if field is None or TYPES.get(field.datatype) != kind or field.offset + kind.itemsize > size:
            raise ValueError(f"{table.name} has no field {name} of type {kind}")
    names, kinds = zip(*_columns(table), strict=True)
    offsets = [found[name].offset for name in names]
    rows = np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": size})
    return np.frombuffer(data, rows.newbyteorder(">") if message.is_bigendian else rows).astype(table.dtype)


def _columns(table: Table) -> list[tuple[str, np.dtype[Any]]]:
    """Names and types."""
    return [(name, table.dtype[name]) for name in table.dtype.names or ()]


def _values(status: Any) -> dict[str, str]:
    if len(status.values) > MAX_VALUES:
        raise ValueError(f"the status has {len(status.values)} values; at most {MAX_VALUES} are allowed")
    return {one.key[:MAX_TEXT]: one.value[:MAX_TEXT] for one in status.values}


def _value(text: str) -> Any:
    """The inverse of `trace_message._text`."""
    if text in WORDS:
        return WORDS[text]
    if INTEGER.fullmatch(text):
        return int(text)
    try:
        return float(text)
    except ValueError:
        return text


def _sequence(name: str, items: tuple[str, ...], found: dict[str, Any]) -> tuple[Any, ...]:
    """The tuple from its items: `status` is text, all others are numbers."""
    good = found.keys() == set(items) and all(
        isinstance(found[item], str if item == "status" else (int, float)) for item in items
    )
    if not good:
        raise ValueError(f"the trace's {name} is {str(found)[:80]}; expected {', '.join(items)}")
    return tuple(found[item] for item in items)


def _header(values: Mapping[str, str]) -> TraceHeader:
    read: dict[str, Any] = {}
    for row in fields(TraceHeader):
        text = values.get(row.name)
        value = text if text is None or row.type == "str" else _value(text)
        value = float(value) if row.type == "float" and type(value) is int else value
        if type(value).__name__ != row.type or (isinstance(value, float) and not math.isfinite(value)):
            raise ValueError(f"the status has no valid {row.name}")
        read[row.name] = value
    return TraceHeader(**read)


@dataclass
class _Step:
    status: TraceStatus | None = None
    tables: dict[str, Any] = field(default_factory=dict)

    def missing(self) -> list[str]:
        """Names of the listed tables that have not arrived."""
        listed = self.status.listed if self.status else ()
        return [table.name for table in listed if table.name not in self.tables]


class TraceReader:
    """Collects the messages of each stamp, with bounded memory."""

    def __init__(self) -> None:
        self._steps: dict[Stamp, _Step] = {}

    def add(self, name: str, message: Any) -> tuple[TraceHeader, Trace] | None:
        """Adds a message of the topic `name` (STATUS or a table); returns the step if it is now complete. Raises
        ValueError for an unreadable message or a step that will never be complete."""
        stamp = message.header.stamp.sec, message.header.stamp.nanosec
        if name == STATUS:
            status = read_status(message)
            self._steps.setdefault(stamp, _Step()).status = status
        else:
            size = memoryview(message.data).nbytes
            if size > MAX_BYTES:
                raise ValueError(f"{name} has {size} bytes; at most {MAX_BYTES} are allowed")
            self._steps.setdefault(stamp, _Step()).tables[name] = message
        return self._completed(stamp)

    def _completed(self, stamp: Stamp) -> tuple[TraceHeader, Trace] | None:
        step = self._steps[stamp]
        if step.status is None or step.missing():
            self._give_up()
            return None
        stamps = list(self._steps)
        for one in stamps[: stamps.index(stamp) + 1]:  # earlier steps are obsolete
            del self._steps[one]
        return step.status.header, step.status.trace(step.tables)

    def _give_up(self) -> None:
        """Drops the oldest incomplete steps, if there are too many."""
        while len(self._steps) > KEPT:
            step = self._steps.pop(next(iter(self._steps)))
            if step.missing():
                raise ValueError(f"{', '.join(step.missing())} of the step did not arrive")
