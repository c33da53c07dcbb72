"""Odometry held against the scans, its own poses and the commands while the node runs.

The driving thread only notes numbers; what is computed is computed in a thread of its own. Nothing waits for anything.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections import Counter, deque
from typing import Any, NamedTuple

import numpy as np

from firstlap import _core
from firstlap.estimation.odometry_check import COMMANDS, STANDING, TWIST, Contradiction, Odometry, Pair, judge
from firstlap.mapping.scan_motion import ScanMotion, ScanStep, as_steps
from firstlap.perception.scan import Mount
from firstlap.ros.conversions import yaw_of

POLL = 0.02
"""[s] between two looks for a new scan."""
LEAST = 0.005
"""[s] between two odometry messages that are noted."""
NOTED = 4096
"""Odometry messages, and commands, that are noted; half of them may be read."""
LOOKED_AT = 70
"""Steps that are kept."""
JUDGED = 3
"""Steps from one judgment to the next."""
CONFIRMED, CONFIRMED_SCALE = 2, 8
"""Judgments in a row that make a gross contradiction; one that only is a factor, and no known mistake, is waited for
until all that it is judged by is new: wheels that spin or lock give one too."""
SWITCH = 5e-4
"""[s] that a thread of Python may keep others waiting; the usual 5 ms are too much for a thread that drives."""
NAMES = {STANDING: "the scans"}
PRESENT = (STANDING, COMMANDS)
"""What is known only while it lasts."""
CARRIED = 10.0
"""[s] after which scans that moved while odometry stood are forgotten: the car was carried. If it was driven, it stands
by now, and only a person lets it try again."""
JUMP = 1.5
"""[m/s] that no car's speed changes by from one step to the next: it was put elsewhere, or ran into something."""


class _Ring:
    """Rows of numbers by time: one thread writes, another reads the newest half, without a lock."""

    def __init__(self, columns: int) -> None:
        self._rows = np.zeros((NOTED, columns))
        self._count = self._first = 0
        self.last = -math.inf

    def note(self, row: tuple[float, ...]) -> None:
        """One more; its first number is the time, and one that goes back begins anew."""
        if row[0] <= self.last:
            self._first = self._count
        self._rows[self._count % NOTED] = row
        self.last = row[0]
        self._count += 1

    def newest(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """(M, columns), in the order of time."""
        count = self._count
        first = max(self._first, count - NOTED // 2)
        return self._rows[np.arange(first, count) % NOTED]


Row = tuple[float, float, float, float, float, float, float]


class _Waiting(NamedTuple):
    scan: _core.LaserScan
    time: float
    mount: Mount


class OdometryWatch:
    """What contradicts what. `reason` and `remarks` may be read at any time."""

    def __init__(self) -> None:
        self.reason = ""
        self.remarks: tuple[str, ...] = ()
        self.compared: tuple[str, ...] = ()
        self.forget()
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def forget(self) -> None:
        """As if nothing had been heard. Not while the thread runs."""
        self._odometry, self._commands = _Ring(7), _Ring(2)
        self._poses_moved = False
        self._first_pose: tuple[float, ...] | None = None
        self._turning: float | None = None
        self._waiting: _Waiting | None = None
        self._done: _Waiting | None = None
        self._mount: Mount | None = None
        self._steps: deque[ScanStep] = deque(maxlen=LOOKED_AT)
        self._verdicts: dict[Pair, tuple[float, Contradiction | None]] = {}
        self._streaks: Counter[Pair] = Counter()
        self._unjudged = 0
        self._told: tuple[str, ...] = ()
        self.reason, self.remarks, self.compared = "", (), ()

    # The driving thread.

    def hear_odometry(self, time: float, twist: Any, pose: Any) -> None:
        """A geometry_msgs/Twist in the car's frame and a Pose."""
        at = pose.position
        self.note((time, twist.linear.x, twist.linear.y, twist.angular.z, at.x, at.y, yaw_of(pose.orientation)))

    def note(self, row: Row) -> None:
        """Time [s], forward, left [m/s], yaw rate [rad/s], x, y [m], yaw [rad]; what is not finite is not noted."""
        time, pose = row[0], row[4:]
        if not math.isfinite(sum(row)) or 0.0 < time - self._odometry.last < LEAST:
            return
        if self._first_pose is None:
            self._first_pose = pose
        self._poses_moved = self._poses_moved or pose != self._first_pose
        turning = row[3] if self._turning is None else self._turning
        self._odometry.note((*row[:3], turning, *pose))

    def hear_yaw_rate(self, yaw_rate: float) -> None:
        """[rad/s] of an IMU, which takes the place of the odometry's."""
        self._turning = yaw_rate

    def hear_command(self, time: float, speed: float) -> None:
        """[m/s]"""
        self._commands.note((time, speed))

    def hear_scan(self, scan: _core.LaserScan, time: float, mount: Mount) -> None:
        """time: [s] of its last beam."""
        self._waiting = _Waiting(scan, time, mount)

    def take_news(self) -> list[str]:
        """Remarks of pairs that were not remarked when this was last called."""
        if self.remarks is self._told:
            return []
        before, self._told = {_about(one) for one in self._told}, self.remarks
        return [one for one in self._told if _about(one) not in before]

    @property
    def summary(self) -> str:
        """In one line."""
        if self.remarks:
            return "; ".join(self.remarks)
        return f"agrees with {', '.join(self.compared)}" if self.compared else "nothing to compare it with yet"

    # The other thread.

    def start(self) -> None:
        """Begins to work in a thread of its own."""
        self.stop()
        self.forget()
        self._over.clear()
        sys.setswitchinterval(SWITCH)
        self._thread = threading.Thread(target=self._run, name="odometry watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends it."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                worked = self.work()
            except Exception as error:  # a check that died must not look like one that found nothing
                self.remarks = (f"odometry is not checked any more: {error!r}",)
                return
            if not worked:
                time.sleep(POLL)

    def work(self) -> bool:
        """One scan, if a new one waits. Whether there was one."""
        waiting = self._waiting
        if waiting is None or waiting is self._done:
            return False
        self._done = waiting
        if waiting.mount != self._mount:
            self._mount, self._motion = waiting.mount, ScanMotion.at(waiting.mount)
            self._steps.clear()
        step = self._motion.add(waiting.scan, waiting.time)
        if step is not None:
            if self._steps and (step.begin < self._steps[-1].begin or _jumps(self._steps[-1], step)):
                self._steps.clear()
            self._steps.append(step)
            self._unjudged += 1
            if self._unjudged >= JUDGED:
                self._unjudged = 0
                self._judge(step.end)
        return True

    def steps(self) -> list[ScanStep]:
        """The newest steps of the scans."""
        return list(self._steps)

    def _judge(self, now: float) -> None:
        rows, commands = self._odometry.newest(), self._commands.newest()
        poses = rows[:, 4:7].copy() if self._poses_moved else None
        if poses is not None:
            poses[:, 2] = np.unwrap(poses[:, 2])
        turning = TWIST if self._turning is None else "the IMU"
        odometry = Odometry(rows[:, 0], rows[:, 1:4], poses, turning)
        steps = as_steps(list(self._steps), commands[:, 0], commands[:, 1])
        self._keep(judge(odometry, steps), now)
        found = [verdict for _, verdict in self._verdicts.values() if verdict is not None]
        self.remarks = tuple(one.text for one in found)
        self.compared = tuple(dict.fromkeys(NAMES.get(pair.reference, pair.reference) for pair in self._verdicts))
        self.reason = next((one.text for one in found if one.gross), "")

    def _keep(self, judged: dict[Pair, Contradiction | None], now: float) -> None:
        """What was judged before stays until it is judged anew."""
        for pair, (when, verdict) in list(self._verdicts.items()):
            carried = verdict is not None and verdict.kind == "zero" and now - when > CARRIED
            if carried or (pair.reference in PRESENT and pair not in judged):
                del self._verdicts[pair]
        for pair in [pair for pair in self._streaks if pair not in judged]:
            del self._streaks[pair]
        for pair, verdict in judged.items():
            grows = verdict is not None and verdict.gross
            self._streaks[pair] = self._streaks[pair] + 1 if grows else 0
            enough = CONFIRMED_SCALE if verdict is not None and verdict.kind == "scale" else CONFIRMED
            if not grows or self._streaks[pair] >= enough:
                self._verdicts[pair] = (now, verdict)


def _jumps(before: ScanStep, after: ScanStep) -> bool:
    """Whether the scans did not go on as they did."""
    speeds = [one.forward / (one.end - one.begin) for one in (before, after)]
    return abs(speeds[1] - speeds[0]) > JUMP


def _about(remark: str) -> str:
    """A remark without its numbers, which change all the time."""
    return "".join(letter for letter in remark if not letter.isdigit())
