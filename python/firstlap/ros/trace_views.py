"""Additional views of a trace, as in the log: lines and markers for RViz and Foxglove."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstlap.recordings import log_messages as ros

Trace = Mapping[str, Any]


@dataclass(frozen=True)
class View:
    """kind: message type. made: builds the messages from a trace, its time [ns], compute time [us], and frame."""

    kind: str
    made: Callable[[Trace, int, float, str], list[bytes]]


def _walls(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.wall(now, side, trace[side]["points"], frame) for side in ("left", "right")]


def _centerline(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.centerline(now, trace["line"]["points"], frame)]


def _path(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.path(now, np.column_stack([trace["path"][name] for name in ("x", "y", "yaw")]), frame)]


def _lookahead(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    """Empty without a path."""
    if not len(trace["path"]["x"]):
        return []
    return [ros.lookahead(now, np.array([trace["lookahead"]["x"], trace["lookahead"]["y"]]), frame)]


def _numbers(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.numbers(np.array([trace["width"], trace["line"]["ahead"], trace["clearance"], step_us]))]


VIEWS: dict[str, dict[str, View]] = {
    "local": {
        "walls": View(ros.MARKER, _walls),
        "centerline": View(ros.PATH, _centerline),
        "path": View(ros.PATH, _path),
        "lookahead": View(ros.POINT, _lookahead),
        "numbers": View(ros.ARRAY, _numbers),
    }
}
"""Driver -> topic name, as in the log -> view."""
