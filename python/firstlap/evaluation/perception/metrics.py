"""Perception metrics.

"Ahead" is the distance along a line from its foot point beside the front axle. The measured line is the planner's
centerline before smoothing and joining (`line`); the driven path (`path`) is measured too where it adds information.

- Lateral error at 0.5, 1, 2, 3 m ahead: distance of the line's point there from the true medial line, over the scans
  whose line reaches that far. `bias` is its signed median, left of the truth positive.
- Width error at the same points: the planner's width there compared with the track's at the nearest medial point.
- Available: share of all scans whose line, planned from this scan, reaches 1, 2, 3 m.
- Failure (`bad` in JSON): a scan with no line at 2 m, or one more than 0.5 m off there; as a share of all scans.
- Jump: distance of this scan's path, 1.5 m ahead, from the previous scan's path, with the car's own motion removed.
- Change of side: a wall point seen by this scan had the other label, left or right, in the previous scan; per meter
  driven and per scan.
- Labels: the side of a return is that of the wall the planner assigned it to. Precision: share of the labeled returns
  whose true side it is; obstacles and scenery have no side, so that labeling them as a wall is wrong. Recall: share of
  the returns from a left or right wall between 2 m behind and 9 m ahead (the planner's horizon) that got their side.
  Returns that no true wall explains, or that could belong to either side, are excluded: their share is `not_judged`.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.evaluation.perception.detections import Detection
from firstlap.evaluation.perception.ground_truth import LEFT, NEITHER, RIGHT, UNKNOWN, GroundTruth
from firstlap.evaluation.replay.continuity import BIG_JUMP, is_touched, jump_of
from firstlap.recordings.recording import LONGEST_PAUSE

FloatArray = npt.NDArray[np.float64]
Pose = tuple[float, float, float]

AHEAD = np.array([0.5, 1.0, 2.0, 3.0])
REACHES = (1.0, 2.0, 3.0)
BAD_AHEAD, BAD_ERROR = 2.0, 0.5
STRETCH_BEHIND, STRETCH_AHEAD = 2.0, 9.0


def foot(line: FloatArray, x: float) -> tuple[FloatArray, FloatArray]:
    """(distance, points): the line (M, 2) from its foot point of (x, 0) on, with the distance from there [m].

    A line that begins ahead of (x, 0) counts from there on.
    """
    if len(line) < 2:
        return np.zeros(0), np.zeros((0, 2))
    a, ab = line[:-1], np.diff(line, axis=0)
    length2 = np.maximum((ab * ab).sum(axis=1), 1e-12)
    t = np.clip((((x, 0.0) - a) * ab).sum(axis=1) / length2, 0.0, 1.0)
    feet = a + t[:, None] * ab
    k = int(np.argmin(np.hypot(feet[:, 0] - x, feet[:, 1])))
    points = np.vstack([feet[k], line[k + 1 :]])
    arc_length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    if k == 0 and t[0] == 0.0:
        arc_length = arc_length + np.hypot(feet[0, 0] - x, feet[0, 1])
    return arc_length, points


def at(arc_length: FloatArray, points: FloatArray, ahead: FloatArray | float) -> FloatArray:
    """(N, 2) points at the distances `ahead` (N,) [m]; NaN beyond the end of the line."""
    wanted = np.atleast_1d(np.asarray(ahead, dtype=np.float64))
    if len(arc_length) == 0:
        return np.full((len(wanted), 2), np.nan)
    found = np.column_stack([np.interp(wanted, arc_length, points[:, i]) for i in (0, 1)])
    found[(wanted > arc_length[-1] + 1e-9) | (wanted < arc_length[0] - 1e-9)] = np.nan
    return found


def to_world(points: FloatArray, pose: Pose) -> FloatArray:
    """Transforms points (N, 2) from base_link to the frame of `pose` (x, y, yaw)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + pose[:2])


@dataclass
class Perception:
    """Collects the perception of each scan; `to_dict` returns the metrics.

    truth: if known. tolerance: maximum distance of a return from its true wall [m].
    """

    truth: GroundTruth | None = None
    tolerance: float = 0.15
    scans: int = 0
    meters: float = 0.0
    changes: int = 0
    reached: Counter[float] = field(default_factory=Counter)
    statuses: Counter[str] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    errors: list[FloatArray] = field(default_factory=list)
    path_errors: list[FloatArray] = field(default_factory=list)
    width_errors: list[FloatArray] = field(default_factory=list)
    jumps: list[float] = field(default_factory=list)
    bad: list[bool] = field(default_factory=list)
    wrong_labels: list[int] = field(default_factory=list)
    _before: tuple[Detection, Pose] | None = None

    def add(self, seen: Detection, pose: Pose, dt: float) -> None:
        """Adds one scan.

        seen: its perception. pose: of base_link at its end, in the map or by odometry. dt: [s] since the last.
        """
        arc_length, line = foot(seen.line, seen.front)
        self.scans += 1
        self.statuses[seen.status] += 1
        for reach in REACHES:
            self.reached[reach] += len(arc_length) > 0 and arc_length[-1] >= reach
        self._compare(seen, pose, dt > LONGEST_PAUSE)
        if self.truth is not None:
            self._evaluate_line(seen, pose, arc_length, line)
            self._evaluate_labels(seen, pose)
        self._before = (seen, pose)

    def _compare(self, seen: Detection, pose: Pose, paused: bool) -> None:
        if self._before is None or paused:
            return
        before, pose_before = self._before
        self.meters += float(np.hypot(pose[0] - pose_before[0], pose[1] - pose_before[1]))
        left, right = to_world(seen.left, pose), to_world(seen.right, pose)
        left_before, right_before = to_world(before.left, pose_before), to_world(before.right, pose_before)
        self.changes += is_touched(left, right_before, left_before) or is_touched(right, left_before, right_before)
        if len(before.path) >= 2 and len(seen.path) >= 2:
            self.jumps.append(jump_of(to_world(seen.path, pose), to_world(before.path, pose_before)))

    def _evaluate_line(self, seen: Detection, pose: Pose, arc_length: FloatArray, line: FloatArray) -> None:
        assert self.truth is not None
        front = to_world(np.array([[seen.front, 0.0]]), pose)[0]
        station = self.truth.station(front[0], front[1], pose[2])

        def error_of(points: FloatArray) -> tuple[FloatArray, npt.NDArray[np.intp]]:
            there = np.isfinite(points).all(axis=1)
            error, index = np.full(len(AHEAD), np.nan), np.full(len(AHEAD), -1)
            if there.any():
                error[there], index[there] = self.truth.beside(  # type: ignore[union-attr]
                    to_world(points[there], pose), station, 1.0, AHEAD[there] + 2.0
                )
            return error, index

        error, index = error_of(at(arc_length, line, AHEAD))
        self.errors.append(error)
        self.path_errors.append(error_of(at(*foot(seen.path, seen.front), AHEAD))[0])
        off = error[AHEAD == BAD_AHEAD][0]
        self.bad.append(bool(np.isnan(off) or abs(off) > BAD_ERROR))
        width = np.full(len(AHEAD), np.nan)
        if len(arc_length):
            tail = seen.line_width[len(seen.line_width) - len(arc_length) + 1 :]
            planned = np.interp(AHEAD, arc_length[1:], tail) if len(tail) else np.full(len(AHEAD), np.nan)
            width = np.where(index >= 0, planned - self.truth.width[index], np.nan)
        self.width_errors.append(width)

    def _evaluate_labels(self, seen: Detection, pose: Pose) -> None:
        assert self.truth is not None
        if len(seen.points) == 0:
            return
        points = to_world(seen.points, pose)
        true = self.truth.side_of(points, self.tolerance)
        front = to_world(np.array([[seen.front, 0.0]]), pose)[0]
        station = self.truth.station(front[0], front[1], pose[2])
        relative = self.truth.stations_from(points, station)
        judged = true != UNKNOWN
        labelled = (seen.side != NEITHER) & judged
        right = labelled & (seen.side == true)
        on_stretch = ((true == LEFT) | (true == RIGHT)) & (relative > -STRETCH_BEHIND) & (relative < STRETCH_AHEAD)
        self.labels["returns"] += len(points)
        self.labels["judged"] += int(judged.sum())
        self.labels["labelled"] += int(labelled.sum())
        self.labels["labelled_right"] += int(right.sum())
        self.labels["on_stretch"] += int(on_stretch.sum())
        self.labels["on_stretch_right"] += int((on_stretch & right).sum())
        self.wrong_labels.append(int((labelled & ~right).sum()))

    def to_dict(self) -> dict[str, Any]:
        """The metrics; None if nothing could be measured. Shares are of all scans, lengths in meters."""
        jumps = np.array(self.jumps)[np.isfinite(self.jumps)]
        found: dict[str, Any] = {
            "scans": self.scans,
            "metres": round(self.meters, 3),
            "statuses": dict(sorted(self.statuses.items())),
            "no_line": _ratio(self.scans - self.statuses["ok"] - self.statuses["blocked"], self.scans),
            "available": {f"{reach:g}": _ratio(self.reached[reach], self.scans) for reach in REACHES},
            "jump": {
                "median": _percentile(jumps, 50),
                "p95": _percentile(jumps, 95),
                "big": _ratio(int((jumps > BIG_JUMP).sum()), len(jumps)),
            },
            "changes_of_side": self.changes,
            "changes_per_metre": _ratio(self.changes, self.meters),
            "changes_per_scan": _ratio(self.changes, self.scans),
        }
        if self.truth is not None:
            found |= {
                "bad": _ratio(sum(self.bad), self.scans),
                "error": _by_distance(self.errors),
                "path_error": _by_distance(self.path_errors),
                "width_error": _by_distance(self.width_errors),
                "precision": _ratio(self.labels["labelled_right"], self.labels["labelled"]),
                "recall": _ratio(self.labels["on_stretch_right"], self.labels["on_stretch"]),
                "not_judged": _ratio(self.labels["returns"] - self.labels["judged"], self.labels["returns"]),
            }
        return found


def _by_distance(rows: list[FloatArray]) -> dict[str, Any]:
    table = np.array(rows).reshape(-1, len(AHEAD))
    found = {}
    for ahead, column in zip(AHEAD, table.T, strict=True):
        values = column[np.isfinite(column)]
        found[f"{ahead:g}"] = {
            "median": _percentile(np.abs(values), 50),
            "p95": _percentile(np.abs(values), 95),
            "bias": _percentile(values, 50),
            "scans": len(values),
        }
    return found


def _percentile(values: FloatArray, q: float) -> float | None:
    return round(float(np.percentile(values, q)), 4) if len(values) else None


def _ratio(part: float, whole: float) -> float | None:
    return round(part / whole, 5) if whole else None
