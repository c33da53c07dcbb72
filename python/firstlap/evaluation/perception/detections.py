"""The perception of one step, extracted from the trace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.evaluation.perception.ground_truth import LEFT, RIGHT, SideArray

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Detection:
    """The perception of one step, in base_link at the end of the sweep [m].

    points: (N, 2) returns used; side: (N,) LEFT, RIGHT or NEITHER, the side of the wall that the line used.
    line: (M, 2) the planner's centerline before smoothing and joining, empty without one; line_width: (M,);
    path: (K, 2) the trajectory planned from this scan, from the front axle on, empty if there is none.
    left, right: (L, 2) samples of the walls visible in this scan.
    front: x of the front axle, from which "ahead" counts.
    """

    status: str
    points: FloatArray
    side: SideArray
    line: FloatArray
    line_width: FloatArray
    path: FloatArray
    left: FloatArray
    right: FloatArray
    front: float

    @classmethod
    def of(cls, trace: Mapping[str, Any], front: float) -> Detection:
        """From `Racer.trace` after a step."""
        status = trace["result"][2]
        points = np.asarray(trace["points"])
        planned = status in ("ok", "blocked")
        line = trace["line"]
        has_sides = len(trace["candidates"]) > 0 and status not in ("bad_scan", "bad_state")
        return cls(
            status=status,
            points=points,
            side=_point_sides(trace) if has_sides else np.zeros(len(points), dtype=np.int8),
            line=np.asarray(line["points"]) if planned else np.zeros((0, 2)),
            line_width=np.asarray(line["width"]) if planned else np.zeros(0),
            path=np.column_stack([trace["path"]["x"], trace["path"]["y"]])[trace["nearest"] :]
            if planned
            else np.zeros((0, 2)),
            left=_seen_now(trace["left"]) if has_sides else np.zeros((0, 2)),
            right=_seen_now(trace["right"]) if has_sides else np.zeros((0, 2)),
            front=front,
        )


def _seen_now(wall: Mapping[str, Any]) -> FloatArray:
    return np.asarray(wall["points"])[np.asarray(wall["age"]) == 0.0]


def _point_sides(trace: Mapping[str, Any]) -> SideArray:
    """A return has the side of its section, and a section has the side of the wall that contains its samples."""
    sections = trace["sections"]
    count = len(sections["first"])
    of_section = np.zeros(count, dtype=np.int8)
    samples = np.asarray(trace["samples"]).astype(np.float32).astype(np.float64)
    keys = samples[:, 0] + 1j * samples[:, 1]
    for name, side in (("right", RIGHT), ("left", LEFT)):
        wall = _seen_now(trace[name])
        taken = np.isin(keys, wall[:, 0] + 1j * wall[:, 1])
        of_section[np.asarray(trace["sample_section"])[taken]] = side
    of_point = np.zeros(len(trace["points"]), dtype=np.int8)
    lengths = np.asarray(sections["last"]) - np.asarray(sections["first"]) + 1
    index = np.repeat(np.asarray(sections["first"]) - np.concatenate([[0], np.cumsum(lengths)[:-1]]), lengths)
    of_point[np.arange(int(lengths.sum())) + index] = np.repeat(of_section, lengths)
    return of_point
