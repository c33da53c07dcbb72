"""The trace of a driver's step as bytes on its way from the car to whoever watches: no pickle, bounded, checked.

Magic, length of the header, header (JSON: what was told, numbers of the trace, and name, kind and shape of each array),
then the arrays one after another, little-endian. Numbers are halved to 32 bits: it is for eyes.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

MAGIC = b"FLT1"
MAX_BYTES = 2_000_000
"""More than any trace has; what is larger is neither sent nor read."""
MAX_HEADER = 200_000
MAX_ARRAYS = 200
MAX_TEXT = 500
SENT = {"f8": "f4", "f4": "f4", "i8": "i4", "i4": "i4", "u1": "u1", "i1": "i1", "b1": "u1"}
"""Kind of an array here -> kind on the way."""
READ = {"f4": np.float64, "i4": np.int64, "u1": np.uint8, "i1": np.int8}
"""Kind on the way -> type for whoever reads."""
HEAD = struct.Struct("<4sI")


@dataclass(frozen=True)
class TraceHeader:
    """What comes with a trace. born: tells one run of the node from the next. time: [s] of the end of the scan, or of
    now where the car stands. speed [m/s], yaw_rate [rad/s], steering_angle [rad]: as the driver took them. step_us:
    its own time. going: whether the car may move. said: why not. sent_speed [m/s], sent_angle [rad]: the command that
    is sent."""

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


def encode(told: TraceHeader, trace: Mapping[str, Any]) -> bytes:
    """A message. Raises ValueError where it would be too large or holds what cannot be sent."""
    kinds: list[tuple[str, str, list[int]]] = []
    bodies: list[bytes] = []
    numbers = _numbers(trace, "", kinds, bodies)
    header = json.dumps({"told": asdict(told), "numbers": numbers, "arrays": kinds}, default=float).encode()
    message = b"".join([HEAD.pack(MAGIC, len(header)), header, *bodies])
    if len(message) > MAX_BYTES or len(header) > MAX_HEADER or len(kinds) > MAX_ARRAYS:
        raise ValueError(f"a trace of {len(message)} bytes in {len(kinds)} arrays is too large to be sent")
    return message


def _numbers(trace: Mapping[str, Any], path: str, kinds: list[Any], bodies: list[bytes]) -> dict[str, Any]:
    """The trace without its arrays, which go to `bodies`."""
    rest: dict[str, Any] = {}
    for name, value in trace.items():
        if isinstance(value, np.ndarray):
            kind = SENT.get(value.dtype.str[1:])
            if kind is None:
                raise ValueError(f"{path}{name}: {value.dtype} cannot be sent")
            kinds.append((path + name, kind, list(value.shape)))
            bodies.append(value.astype("<" + kind).tobytes())
        elif isinstance(value, Mapping):
            rest[name] = _numbers(value, f"{path}{name}.", kinds, bodies)
        else:
            rest[name] = value
    return rest


def decode(message: bytes) -> tuple[TraceHeader, dict[str, Any]]:
    """What was told and the trace, its arrays float64, int64 or of single bytes. Raises ValueError."""
    if not HEAD.size < len(message) <= MAX_BYTES:
        raise ValueError(f"{len(message)} bytes are no trace")
    magic, length = HEAD.unpack_from(message)
    if magic != MAGIC or not 2 <= length <= min(MAX_HEADER, len(message) - HEAD.size):
        raise ValueError("this is no trace of this version of firstlap")
    try:
        header = json.loads(message[HEAD.size : HEAD.size + length])
    except (ValueError, RecursionError) as error:
        raise ValueError(f"the trace's header cannot be read: {str(error)[:80]}") from None
    if not isinstance(header, dict) or not isinstance(header.get("numbers"), dict):
        raise ValueError("the trace's header has no numbers")
    trace = header["numbers"]
    at = HEAD.size + length
    for path, kind, shape in _arrays(header.get("arrays")):
        size = math.prod(shape) * np.dtype(kind).itemsize
        if at + size > len(message):
            raise ValueError(f"{path} is cut off")
        sent = np.frombuffer(message, "<" + kind, math.prod(shape), at)
        with np.errstate(invalid="ignore"):  # a NaN of any kind stays one
            array = sent.astype(READ[kind]).reshape(shape)
        _put(trace, path, array)
        at += size
    if at != len(message):
        raise ValueError(f"{len(message) - at} bytes too many")
    return _told(header.get("told")), trace


def _arrays(listed: Any) -> Iterator[tuple[str, str, list[int]]]:
    if not isinstance(listed, list) or len(listed) > MAX_ARRAYS:
        raise ValueError("the trace's list of arrays is none")
    for one in listed:
        path, kind, shape = one if isinstance(one, list) and len(one) == 3 else ("", "", [])
        good = isinstance(path, str) and isinstance(kind, str) and kind in READ and isinstance(shape, list)
        if not (good and 1 <= len(shape) <= 3 and all(type(n) is int and 0 <= n <= MAX_BYTES for n in shape)):
            raise ValueError(f"the trace has an array that cannot be: {str(one)[:80]}")
        yield path, kind, shape


def _put(trace: dict[str, Any], path: str, array: npt.NDArray[Any]) -> None:
    """Where its path says, beside the numbers."""
    *folders, name = path.split(".")
    for folder in folders:
        trace = trace.setdefault(folder, {})
        if not isinstance(trace, dict):
            raise ValueError(f"{path[:80]}: {folder[:40]} is a number")
    if name in trace:
        raise ValueError(f"{path[:80]} comes twice")
    trace[name] = array


def _told(told: Any) -> TraceHeader:
    types: dict[str, type] = {"str": str, "float": float, "bool": bool}
    values: dict[str, Any] = {}
    for row in fields(TraceHeader):
        value = told.get(row.name) if isinstance(told, dict) else None
        kind = types[str(row.type)]
        value = float(value) if kind is float and type(value) is int else value
        if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
            raise ValueError(f"the trace says no {row.name}")
        values[row.name] = value[:MAX_TEXT] if isinstance(value, str) else value
    return TraceHeader(**values)
