"""The laps of a recording with poses: from the place where the car begins to move, round to it again."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from firstlap.recordings.recording import Recording
from firstlap.view.frame import DrivenLap

Floats = npt.NDArray[np.float64]

MOVING = 0.3
"""[m/s]"""
GATE = 2.0
"""[m] that the line reaches to either side of the place."""
SHORTEST = 5.0
"""[m] of a lap at least."""


def laps_of(recording: Recording) -> list[tuple[int, DrivenLap]]:
    """Complete laps, each with the first scan after it. None without poses, or where the line is not passed again."""
    if recording.poses is None or len(recording) < 3:
        return []
    moving = np.flatnonzero((recording.speed > MOVING) & np.isfinite(recording.poses).all(axis=1))
    if len(moving) == 0:
        return []
    begin = int(moving[0])
    found: list[tuple[int, DrivenLap]] = []
    since, first = float(recording.stamps[begin]), begin
    for scan, share in _crossings(recording.poses, begin):
        now = float(recording.stamps[scan - 1] + share * (recording.stamps[scan] - recording.stamps[scan - 1]))
        rows = slice(first, scan + 1)
        standing = not found and begin > 0 and abs(float(recording.speed[begin - 1])) <= MOVING
        line, speed = recording.poses[rows, :2].copy(), recording.speed[rows].copy()
        found.append((scan, DrivenLap(len(found) + 1, now - since, line, speed, None, standing)))
        since, first = now, scan
    return found


def _crossings(poses: Floats, begin: int) -> list[tuple[int, float]]:
    """(i, share): forward over the line between pose i - 1 and pose i."""
    x, y, yaw = poses[begin]
    c, s = np.cos(yaw), np.sin(yaw)
    dx, dy = poses[:, 0] - x, poses[:, 1] - y
    ahead, left = c * dx + s * dy, c * dy - s * dx
    steps = np.hypot(np.diff(poses[:, 0]), np.diff(poses[:, 1]))
    way = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0))])
    over = (ahead[:-1] < 0.0) & (ahead[1:] >= 0.0) & (np.abs(left[1:]) < GATE) & (np.abs(left[:-1]) < GATE)
    found: list[tuple[int, float]] = []
    last = float(way[begin])
    for i in (np.flatnonzero(over) + 1).tolist():
        if i <= begin or way[i] - last < SHORTEST:
            continue
        found.append((i, float(-ahead[i - 1] / (ahead[i] - ahead[i - 1]))))
        last = float(way[i])
    return found
