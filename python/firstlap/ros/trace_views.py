"""What the log holds of a step beside its tables, made from the trace: lines and markers for RViz and Foxglove."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from firstlap.recordings import log_messages as ros

Trace = Mapping[str, Any]


@dataclass(frozen=True)
class View:
    """kind: of its messages. made: these, of a trace, its time [ns], the time that it took [us], and the frame."""

    kind: str
    made: Callable[[Trace, int, float, str], list[bytes]]


def _walls(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.wall(now, side, trace[side]["points"], frame) for side in ("left", "right")]


def _centerline(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.centerline(now, trace["line"]["points"], frame)]


def _path(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    return [ros.path(now, np.column_stack([trace["path"][name] for name in ("x", "y", "yaw")]), frame)]


def _lookahead(trace: Trace, now: int, step_us: float, frame: str) -> list[bytes]:
    """Nothing without a path."""
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
"""Driver -> name of the topic -> view; under the names that they have in the log."""
