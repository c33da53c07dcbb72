"""Checks odometry against scans, its own poses and commands while the node runs.

The driving thread only records numbers; a separate thread computes. Neither waits for the other.
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
"""[s] Polling period for new scans."""
MIN_PERIOD = 0.005
"""[s] Minimum period of recorded odometry messages."""
BUFFER_SIZE = 4096
"""Size of the buffers of odometry messages and of commands; half of it may be read."""
KEPT_STEPS = 70
"""Number of scan steps kept."""
CHECK_INTERVAL = 3
"""Number of scan steps between two checks."""
CONFIRMED, CONFIRMED_SCALE = 2, 8
"""Number of consecutive checks that confirm a gross contradiction. A wrong scale without a known cause needs entirely
new data, because spinning or locking wheels cause it too."""
SWITCH = 5e-4
"""[s] Thread switch interval of Python; the default 5 ms would delay the driving thread too much."""
NAMES = {STANDING: "the scans"}
PRESENT = (STANDING, COMMANDS)
"""References that are only valid while they are available."""
CARRIED = 10.0
"""[s] After this time, a motion in the scans with odometry at zero is discarded: the car was carried. If it was
driving, it has stopped by now, and only a person can restart it."""
JUMP = 1.5
"""[m/s] A larger change of speed between two steps means that the car was moved by hand or hit something."""


class _Ring:
    """A lock-free ring buffer of rows ordered by time: one thread writes, another reads the newest half."""

    def __init__(self, columns: int) -> None:
        self._rows = np.zeros((BUFFER_SIZE, columns))
        self._count = self._first = 0
        self.last = -math.inf

    def note(self, row: tuple[float, ...]) -> None:
        """Adds a row, which begins with the time. A decreasing time clears the buffer."""
        if row[0] <= self.last:
            self._first = self._count
        self._rows[self._count % BUFFER_SIZE] = row
        self.last = row[0]
        self._count += 1

    def newest(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """(M, columns) rows, ordered by time."""
        count = self._count
        first = max(self._first, count - BUFFER_SIZE // 2)
        return self._rows[np.arange(first, count) % BUFFER_SIZE]


Row = tuple[float, float, float, float, float, float, float]


class _Waiting(NamedTuple):
    scan: _core.LaserScan
    time: float
    mount: Mount


class OdometryWatch:
    """Checks odometry. `reason` and `remarks` may be read at any time."""

    def __init__(self) -> None:
        self.reason = ""
        self.remarks: tuple[str, ...] = ()
        self.compared: tuple[str, ...] = ()
        self.forget()
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def forget(self) -> None:
        """Resets the state. Not while the thread runs."""
        self._odometry, self._commands = _Ring(7), _Ring(2)
        self._poses_moved = False
        self._first_pose: tuple[float, ...] | None = None
        self._yaw_rate: float | None = None
        self._waiting: _Waiting | None = None
        self._done: _Waiting | None = None
        self._mount: Mount | None = None
        self._steps: deque[ScanStep] = deque(maxlen=KEPT_STEPS)
        self._verdicts: dict[Pair, tuple[float, Contradiction | None]] = {}
        self._streaks: Counter[Pair] = Counter()
        self._unchecked = 0
        self._reported: tuple[str, ...] = ()
        self.reason, self.remarks, self.compared = "", (), ()

    # The driving thread.

    def add_odometry(self, time: float, twist: Any, pose: Any) -> None:
        """Adds odometry: a geometry_msgs/Twist in the car's frame and a Pose."""
        at = pose.position
        self.note((time, twist.linear.x, twist.linear.y, twist.angular.z, at.x, at.y, yaw_of(pose.orientation)))

    def note(self, row: Row) -> None:
        """Records time [s], forward and lateral speed [m/s], yaw rate [rad/s], x, y [m], yaw [rad]; ignores non-finite
        rows."""
        time, pose = row[0], row[4:]
        if not math.isfinite(sum(row)) or 0.0 < time - self._odometry.last < MIN_PERIOD:
            return
        if self._first_pose is None:
            self._first_pose = pose
        self._poses_moved = self._poses_moved or pose != self._first_pose
        turning = row[3] if self._yaw_rate is None else self._yaw_rate
        self._odometry.note((*row[:3], turning, *pose))

    def add_yaw_rate(self, yaw_rate: float) -> None:
        """Adds an IMU's yaw rate [rad/s], which replaces the odometry's."""
        self._yaw_rate = yaw_rate

    def add_command(self, time: float, speed: float) -> None:
        """Adds a commanded speed [m/s]."""
        self._commands.note((time, speed))

    def add_scan(self, scan: _core.LaserScan, time: float, mount: Mount) -> None:
        """Adds a scan. time: of its last beam [s]."""
        self._waiting = _Waiting(scan, time, mount)

    def take_news(self) -> list[str]:
        """Remarks that are new since the last call."""
        if self.remarks is self._reported:
            return []
        before, self._reported = {_about(one) for one in self._reported}, self.remarks
        return [one for one in self._reported if _about(one) not in before]

    @property
    def summary(self) -> str:
        """The result in one line."""
        if self.remarks:
            return "; ".join(self.remarks)
        return f"agrees with {', '.join(self.compared)}" if self.compared else "nothing to compare with yet"

    # The other thread.

    def start(self) -> None:
        """Starts the thread."""
        self.stop()
        self.forget()
        self._over.clear()
        sys.setswitchinterval(SWITCH)
        self._thread = threading.Thread(target=self._run, name="odometry watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                worked = self.work()
            except Exception as error:  # a failed check must not look like one without findings
                self.remarks = (f"odometry is no longer checked: {error!r}",)
                return
            if not worked:
                time.sleep(POLL)

    def work(self) -> bool:
        """Processes the newest scan, if there is one. Returns whether there was."""
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
            self._unchecked += 1
            if self._unchecked >= CHECK_INTERVAL:
                self._unchecked = 0
                self._check(step.end)
        return True

    def steps(self) -> list[ScanStep]:
        """The newest scan steps."""
        return list(self._steps)

    def _check(self, now: float) -> None:
        rows, commands = self._odometry.newest(), self._commands.newest()
        poses = rows[:, 4:7].copy() if self._poses_moved else None
        if poses is not None:
            poses[:, 2] = np.unwrap(poses[:, 2])
        turning = TWIST if self._yaw_rate is None else "the IMU"
        odometry = Odometry(rows[:, 0], rows[:, 1:4], poses, turning)
        steps = as_steps(list(self._steps), commands[:, 0], commands[:, 1])
        self._keep(judge(odometry, steps), now)
        found = [verdict for _, verdict in self._verdicts.values() if verdict is not None]
        self.remarks = tuple(one.text for one in found)
        self.compared = tuple(dict.fromkeys(NAMES.get(pair.reference, pair.reference) for pair in self._verdicts))
        self.reason = next((one.text for one in found if one.gross), "")

    def _keep(self, judged: dict[Pair, Contradiction | None], now: float) -> None:
        """Updates the verdicts; a pair that was not checked now keeps its verdict."""
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
    """Whether the speed changed implausibly between two steps."""
    speeds = [one.forward / (one.end - one.begin) for one in (before, after)]
    return abs(speeds[1] - speeds[0]) > JUMP


def _about(remark: str) -> str:
    """A remark without its numbers, to recognize its kind."""
    return "".join(letter for letter in remark if not letter.isdigit())
