"""The process in which a simulated race runs: real time or a factor of it, messages in, frames out.

Nothing here waits for the viewer's process: a frame goes out only when one was asked for, by a thread that is the only
one to wait for the pipe. When the viewer's process is gone, so is this one.
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

BEHIND = 4.0
"""Scan periods the race may be late before it gives the lost time up."""
SAID_EVERY = 0.2
"""[s] between two words about a driver's preparation."""
PREPARING = "preparing"
"""What these words begin with."""


def run(plan: Plan, connection: Connection, lifeline: Connection) -> None:
    """The process's main function. lifeline: nothing comes through it; it ends with the viewer's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the viewer's
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
    """Sends in a thread of its own. Only as much waits in it as was asked for."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._queue: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._run, name="outbox", daemon=True).start()

    def put(self, message: object) -> None:
        """Packed here and now, so that what drives and what is sent share no lock later."""
        self._queue.put(pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL))

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                self._connection.send_bytes(self._queue.get())
        os._exit(0)


class _Loop:
    def __init__(self, plan: Plan, connection: Connection) -> None:
        self.connection = connection
        self.outbox = FrameSender(connection)
        self.race = SimRace(plan)
        self.asked: tuple[int, int] | None = None
        self.sent = -1
        self.wanted: Setup | None = plan.setup
        self.late: deque[float] = deque(maxlen=8000)
        self.told: dict[str, Callable[..., object]] = {
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
        """Until the viewer's process says so, or is gone."""
        self.anchor = monotonic()
        self.periods = 0
        while True:
            self.listen(self.due - monotonic())
            self.take_setup()
            self.tick_if_due()
            self.answer()

    # Time.

    @property
    def step(self) -> float:
        """[s] of the wall clock between two scans."""
        return self.race.period / self.race.conditions.pace

    @property
    def due(self) -> float:
        """monotonic() of the next scan."""
        return self.anchor + (self.periods + 1) * self.step

    def from_now(self) -> None:
        """Time that passed otherwise is no time that is late."""
        self.anchor, self.periods = monotonic(), 0

    def tick_if_due(self) -> None:
        """One scan period when its time has come. Lost time is given up, not run after."""
        late = monotonic() - self.due
        if late < 0.0:
            return
        self.late.append(1e6 * late)
        if late > BEHIND * self.step:
            self.anchor += late
        self.race.tick()
        self.periods += 1

    # Messages.

    def listen(self, waiting: float) -> None:
        """Waits so long [s], or for words, which count at once; takes all that have come."""
        while self.connection.poll(max(waiting, 0.0)):
            name, *arguments = self.connection.recv()
            if name == "close":
                os._exit(0)
            try:
                self.told[name](*arguments)
            except InputError as error:
                self.race.say(str(error))
            waiting = 0.0

    def on_ask(self, epoch: int, laps: int) -> None:
        """The viewer's process has room for one frame; it has so many laps of that epoch."""
        self.asked = (epoch, laps)

    def on_stop(self) -> None:
        """At this very moment, not at the next scan."""
        since = (monotonic() - self.due + self.step) * self.race.conditions.pace
        self.race.stop(max(since, 0.0))

    def on_setup(self, setup: Setup) -> None:
        """Of several that came together only the last one counts."""
        self.wanted = setup

    def on_place(self, pose: Pose) -> None:
        """By hand."""
        self.race.place(pose)

    def on_condition(self, key: str, value: Value) -> None:
        """Also the pace."""
        self.race.set_condition(key, value)
        self.from_now()

    def on_timing(self) -> None:
        """Step times by CPU and wall clock and lateness of the scans [us], since the last time it was asked."""
        steps, late = np.array(self.race.times).reshape(-1, 2), np.array(self.late)
        self.race.times.clear()
        self.late.clear()
        self.outbox.put(("timing", steps, late))

    def take_setup(self) -> None:
        """What was wanted drives, or the frames say why not."""
        setup, self.wanted = self.wanted, None
        if setup is None:
            return
        if driver_kind(setup.driver).needs_map:
            self.race.say(f"{PREPARING}: driver {setup.driver}")
            self.listen(SAID_EVERY)
            self.answer()
        try:
            self.race.set_setup(setup, self.preparing())
        except InputError as error:
            self.race.say(f"{setup.title}: {error}")
        self.from_now()

    def preparing(self) -> Callable[[str, float], object]:
        """Hears of a driver's preparation, says it in the frames, and answers meanwhile."""
        last = [0.0]

        def look(what: str, share: float) -> None:
            if monotonic() - last[0] < SAID_EVERY:
                return
            last[0] = monotonic()
            self.race.say(f"{PREPARING}: {what}, {100.0 * share:.0f} %")
            self.from_now()
            self.listen(0.0)
            self.answer()

        return look

    # Frames.

    def answer(self) -> None:
        """Hands over the newest frame, where one was asked for and there is a new one."""
        race = self.race
        if self.asked is None or race.number == self.sent:
            return
        epoch, count = self.asked
        laps = race.laps if epoch != race.epoch else tuple(lap for lap in race.laps if lap.number > count)
        self.asked, self.sent = None, race.number
        self.outbox.put(("frame", race.frame(), race.epoch, laps))
