"""The process of a simulated race: runs at a multiple of real time, receives messages, sends frames.

The race never waits for the viewer's process: frames are sent only on request, by a separate thread, which alone may
block on the pipe. This process ends with the viewer's process.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import threading
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection
from time import monotonic

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup
from firstlap.pitwall.frame import Pose
from firstlap.pitwall.sim_race import Plan, SimRace

MAX_LAG = 4.0
"""Lag in scan periods after which the lost time is skipped."""
PROGRESS_PERIOD = 0.2
"""[s] Period of messages about a driver's preparation."""
PREPARING = "preparing"
"""Prefix of these messages."""


def run(plan: Plan, connection: Connection, lifeline: Connection) -> None:
    """Main function of the process. lifeline: carries no data; it closes when the viewer's process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the viewer's process handles Ctrl-C
    threading.Thread(target=_end_with, args=(lifeline,), name="lifeline", daemon=True).start()
    try:
        _Loop(plan, connection).run()
    except (EOFError, OSError):
        os._exit(0)


def _end_with(lifeline: Connection) -> None:
    with contextlib.suppress(EOFError, OSError):
        lifeline.recv_bytes()
    os._exit(0)


class FrameSender:
    """Sends messages in a separate thread. Its queue is bounded by the requests."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._queue: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._run, name="frame sender", daemon=True).start()

    def put(self, message: object) -> None:
        """Queues a message; pickles it at once, so that the race and the sender share no data."""
        self._queue.put(pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL))

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                self._connection.send_bytes(self._queue.get())
        os._exit(0)


class _Loop:
    def __init__(self, plan: Plan, connection: Connection) -> None:
        self.connection = connection
        self.sender = FrameSender(connection)
        self.race = SimRace(plan)
        self.asked: tuple[int, int] | None = None
        self.sent = -1
        self.requested_setup: Setup | None = plan.setup
        self.late: deque[float] = deque(maxlen=8000)
        self.handlers: dict[str, Callable[..., object]] = {
            "ask": self.on_ask,
            "stop": self.on_stop,
            "go": self.race.go,
            "restart": self.race.restart,
            "place": self.on_place,
            "setup": self.on_setup,
            "condition": self.on_condition,
            "timing": self.on_timing,
        }

    def run(self) -> None:
        """Runs until the viewer's process ends it or disappears."""
        self.anchor = monotonic()
        self.periods = 0
        while True:
            self.listen(self.due - monotonic())
            self.take_setup()
            self.tick_if_due()
            self.answer()

    # Timing.

    @property
    def step(self) -> float:
        """[s] Scan period in wall-clock time."""
        return self.race.period / self.race.conditions.pace

    @property
    def due(self) -> float:
        """Time of the next scan, as of monotonic()."""
        return self.anchor + (self.periods + 1) * self.step

    def from_now(self) -> None:
        """Restarts the schedule now; time spent on other work does not count as lag."""
        self.anchor, self.periods = monotonic(), 0

    def tick_if_due(self) -> None:
        """Simulates one scan period if it is due. Lost time is skipped, not caught up."""
        late = monotonic() - self.due
        if late < 0.0:
            return
        self.late.append(1e6 * late)
        if late > MAX_LAG * self.step:
            self.anchor += late
        self.race.tick()
        self.periods += 1

    # Messages.

    def listen(self, waiting: float) -> None:
        """Handles all received messages; waits up to `waiting` [s] for the first one."""
        while self.connection.poll(max(waiting, 0.0)):
            name, *arguments = self.connection.recv()
            if name == "close":
                os._exit(0)
            try:
                self.handlers[name](*arguments)
            except InputError as error:
                self.race.report(str(error))
            waiting = 0.0

    def on_ask(self, epoch: int, laps: int) -> None:
        """Requests one frame; the viewer's process has this number of laps of that epoch."""
        self.asked = (epoch, laps)

    def on_stop(self) -> None:
        """Stops immediately, not at the next scan."""
        since = (monotonic() - self.due + self.step) * self.race.conditions.pace
        self.race.stop(max(since, 0.0))

    def on_setup(self, setup: Setup) -> None:
        """Requests a setup; of several pending ones, the last counts."""
        self.requested_setup = setup

    def on_place(self, pose: Pose) -> None:
        """Places the car."""
        self.race.place(pose)

    def on_condition(self, key: str, value: Value) -> None:
        """Sets a condition, which may be the pace."""
        self.race.set_condition(key, value)
        self.from_now()

    def on_timing(self) -> None:
        """Sends the step times (CPU and wall clock) and the scans' lag [us] since the last request."""
        steps, late = np.array(self.race.times).reshape(-1, 2), np.array(self.late)
        self.race.times.clear()
        self.late.clear()
        self.sender.put(("timing", steps, late))

    def take_setup(self) -> None:
        """Applies the requested setup, or reports in the frames why that failed."""
        setup, self.requested_setup = self.requested_setup, None
        if setup is None:
            return
        if driver_kind(setup.driver).needs_map:
            self.race.report(f"{PREPARING}: driver {setup.driver}")
            self.listen(PROGRESS_PERIOD)
            self.answer()
        try:
            self.race.set_setup(setup, self.preparing())
        except InputError as error:
            self.race.report(f"{setup.title}: {error}")
        self.from_now()

    def preparing(self) -> Callable[[str, float], object]:
        """A progress callback for a driver's preparation: reports it in the frames and handles messages meanwhile."""
        last = [0.0]

        def on_progress(what: str, share: float) -> None:
            if monotonic() - last[0] < PROGRESS_PERIOD:
                return
            last[0] = monotonic()
            self.race.report(f"{PREPARING}: {what}, {100.0 * share:.0f} %")
            self.from_now()
            self.listen(0.0)
            self.answer()

        return on_progress

    # Frames.

    def answer(self) -> None:
        """Sends the newest frame if it is new and was requested."""
        race = self.race
        if self.asked is None or race.number == self.sent:
            return
        epoch, count = self.asked
        laps = race.laps if epoch != race.epoch else tuple(lap for lap in race.laps if lap.number > count)
        self.asked, self.sent = None, race.number
        self.sender.put(("frame", race.frame(), race.epoch, laps))
