"""A simulated race in a process of its own, as a source of frames."""

from __future__ import annotations

import math
import multiprocessing
import threading
from collections.abc import Mapping
from dataclasses import replace
from multiprocessing.context import SpawnProcess
from time import monotonic, sleep
from typing import Any

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import FieldTable, Value
from firstlap.config.setup_file import Setup
from firstlap.pitwall.conditions import Conditions, checked_pace
from firstlap.pitwall.frame import DrivenLap, Frame, Pose, Scenery
from firstlap.pitwall.holding import Holding
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.mailbox import CLOSE, Mailbox, Message
from firstlap.pitwall.sim_laps import with_lap
from firstlap.pitwall.sim_process import PREPARING, run
from firstlap.pitwall.sim_race import CAR, Plan, make_world
from firstlap.sim.race_process import bare, packed
from firstlap.tracks.track import Track

ASKED_EVERY = 0.02
"""[s] between two frames that are asked for, at least."""
SILENCE = 2.0
"""[s] without a frame after which the viewers are told, and a restart begins another process."""
BEGINS = 20.0
"""[s] without a first frame after which that is so."""
PATIENCE = 0.5
"""[s] for the race to end by itself when it is told to, and again when it is told otherwise."""


class SimSource(Holding):
    """A `Source` that `Drives` and `Simulates`. Raises InputError for a car that cannot start on the track.

    track: as it is driven. pace: times real time.
    """

    def __init__(self, track: Track, setup: Setup, car: Car, *, seed: int = 1, pace: float = 1.0) -> None:
        if not 0 <= seed < 2**63:
            raise InputError(f"seed is {seed}, outside of what is allowed: 0 to 2^63 - 1")
        self.title = track.name
        self.track, self.car, self.seed = track, car, seed
        self.scenery = scenery_of(track)
        self._conditions = Conditions(car, checked_pace(pace))
        self._world = make_world(track, car, self._conditions, seed)
        self._check(setup)
        super().__init__(setup)
        self._going, self._closed, self._silent = True, False, False
        self._lock = threading.RLock()
        self._laps: tuple[DrivenLap, ...] = ()
        self._epoch = -1
        self._race: _Race | None = None
        self._timing: tuple[Any, Any] | None = None
        self._timed = threading.Event()

    # A source.

    def start(self) -> None:
        """The race begins, in its process."""
        with self._lock:
            if self._race is None and not self._closed:
                plan = Plan(
                    bare(self.track), packed(self.car), self._setup, self.seed, self._conditions.values, self._going
                )
                self._epoch, self._silent = -1, False
                self._race = _Race(plan, self._hear, self._died)

    def close(self) -> None:
        """Ends the race's process."""
        with self._lock:
            self._closed = True
            race, self._race = self._race, None
        if race is not None:
            race.end()

    def change(self, values: Mapping[str, Value]) -> None:
        """Parameters by section.name, while driving."""
        with self._lock:
            self._take(changed_from(self._setup.with_values(values), self._loaded))

    def choose(self, setup: Setup) -> None:
        """Another setup. A driver that needs a map makes it first, and begins at the line."""
        with self._lock:
            self._take(setup)
            self._loaded = setup

    def _take(self, setup: Setup) -> None:
        self._check(setup)
        self._tell("setup", setup)
        self._setup = setup

    def _check(self, setup: Setup) -> None:
        setup.validate(f"{setup.title} on car {self.car.name}", self.car.core)

    # It drives.

    def stop(self) -> None:
        """Emergency stop."""
        self._going = False
        self._tell("stop", may_fail=True)

    def go(self) -> None:
        """Drives on."""
        self._going = True
        self._tell("go", may_fail=True)

    # It simulates.

    @property
    def conditions(self) -> FieldTable:
        """Of the simulated car and its world; the defaults are the loaded car's."""
        return self._conditions.table

    def condition(self, name: str) -> Value:
        """One of them now."""
        return self._conditions.get(name)

    def set_condition(self, name: str, value: Value) -> None:
        """Changes one while driving."""
        with self._lock:
            before = self._conditions.get(name)
            key = self._conditions.set(name, value)
            try:
                self._tell("condition", key, self._conditions.values[key])
            except InputError:
                self._conditions.set(key, before)
                raise

    def restart(self) -> None:
        """Back to the line, at rest; laps begin anew. A race whose process has died, or hangs, begins anew, too."""
        with self._lock:
            if self._silent and self._race is not None:
                silent, self._race = self._race, None
                silent.kill()
            if self._race is None:
                self.start()
                if self._frame:
                    self._show(self._frame, said="another race begins")
            else:
                self._tell("restart")

    def place(self, pose: Pose) -> None:
        """The car stands there, at rest. Raises InputError on or behind a wall, and for a driver with a map that would
        look back."""
        if not all(math.isfinite(value) for value in pose):
            raise InputError(f"the car cannot stand at {pose}: expected x, y [m] and yaw [rad]")
        x, y, yaw = (float(value) for value in pose)
        if _outside(self.track, x, y):
            raise InputError(f"x = {x:.2f} m, y = {y:.2f} m is not on the track: expected a place between its walls")
        if driver_kind(self._setup.driver).needs_map and _looks_back(self.track, x, y, yaw):
            raise InputError(f"driver {self._setup.driver} drives its line one way only: turn the car round")
        with self._lock:
            if not self._world.fits(CAR, x, y, yaw):
                raise InputError(f"the car does not fit at x = {x:.2f} m, y = {y:.2f} m: it would touch a wall")
            self._tell("place", (x, y, yaw))

    # For measurements.

    def timing(self, patience: float = 2.0) -> tuple[Any, Any]:
        """Since it was asked last: the steps' times by CPU and wall clock (N, 2), and how late the scans were (M,),
        all in microseconds. Raises InputError where the race does not answer."""
        self._timed.clear()
        self._tell("timing")
        if not self._timed.wait(patience) or self._timing is None:
            raise InputError(f"{self.title}: the race does not answer")
        return self._timing

    # The other process.

    def _tell(self, *message: Any, may_fail: bool = False) -> None:
        """Raises InputError where there is no race any more."""
        race = self._race  # no lock: a stop waits for nothing
        if race is None and not (may_fail or self._frame is None):
            raise InputError("the race has ended: restart begins another")
        if race is not None:
            race.tell(message)

    def _hear(self, race: _Race, message: Message) -> Message:
        """Takes what the race sent; the answer asks for more. One that was given up has nothing to say."""
        with self._lock:
            if self._race is not race:
                return ("ask", -1, 0)
            return self._heard(message)

    def _heard(self, message: Message) -> Message:
        if message[0] == "frame":
            _, frame, epoch, laps = message
            self._silent = False
            if epoch != self._epoch:
                self._laps = ()
            self._epoch = epoch
            for lap in laps:
                self._laps = with_lap(self._laps, lap)
            self._show(frame, laps=self._laps)
        elif message[0] == "silence":
            frame = self._frame or _nothing(self._world)
            if not frame.said.startswith(PREPARING):
                self._silent = True
                self._show(frame, going=False, said="the race does not answer: restart begins another")
        elif message[0] == "timing":
            self._timing = message[1:]
            self._timed.set()
        return ("ask", self._epoch, self._laps[-1].number if self._laps else 0)

    def _died(self, race: _Race, how: str) -> None:
        with self._lock:
            if self._race is not race:
                return
            self._race = None
            self._show(self._frame or _nothing(self._world), going=False, said=f"the race has ended: {how}; restart")

    def _show(self, frame: Frame, **changed: Any) -> None:
        self._number += 1
        self._frame = replace(frame, number=self._number, **changed)


class _Race:
    """The process, and the thread that hears it."""

    def __init__(self, plan: Plan, hear: Any, died: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        their_life, self._life = context.Pipe(duplex=False)
        self.process: SpawnProcess = context.Process(
            target=run, args=(plan, theirs, their_life), name="firstlap race", daemon=True
        )
        self.process.start()
        theirs.close()
        their_life.close()
        self._hear, self._died = hear, died
        self._mailbox = Mailbox(self._connection)
        self._thread = threading.Thread(target=self._listen, name="race", daemon=True)
        self._thread.start()

    def tell(self, message: Message) -> None:
        """Never waits. To a process that is gone: nothing; `died` was, or will be, called."""
        self._mailbox.put(message)

    def _listen(self) -> None:
        self.tell(("ask", -1, 0))
        last = 0.0
        try:
            while True:
                while not self._connection.poll(SILENCE if last else BEGINS):
                    self._hear(self, ("silence",))
                message = self._connection.recv()
                answer = self._hear(self, message)
                if message[0] == "frame":
                    sleep(max(0.0, last + ASKED_EVERY - monotonic()))
                    last = monotonic()
                    self.tell(answer)
        except (EOFError, OSError):
            self.process.join(PATIENCE)
            self._died(self, _how(self.process.exitcode))

    def kill(self) -> None:
        """It does not answer."""
        self.process.kill()
        self.process.join(PATIENCE)
        self._left()

    def end(self) -> None:
        """Tells it to, and sees to it."""
        self.tell((CLOSE,))
        self.process.join(PATIENCE)
        for end in (self.process.terminate, self.process.kill):
            if self.process.is_alive():
                end()
                self.process.join(PATIENCE)
        self._left()

    def _left(self) -> None:
        self.tell((CLOSE,))  # ends the thread that sends
        self._life.close()
        self._thread.join(PATIENCE)


def _how(code: int | None) -> str:
    if code is None:
        return "its process does not answer"
    return f"its process was ended by signal {-code}" if code < 0 else f"its process ended with exit code {code}"


def _nothing(world: Any) -> Frame:
    start = world.truth(CAR)
    return Frame(0, 0.0, (start["x"], start["y"], start["yaw"]), 0.0, 0.0, 0.0, "", {}, 0.0)


def _nearest(track: Track, x: float, y: float) -> tuple[int, float]:
    """The centerline's nearest point and how far [m] it is."""
    distance = np.hypot(track.centerline[:, 0] - x, track.centerline[:, 1] - y)
    nearest = int(np.argmin(distance))
    return nearest, float(distance[nearest])


def _outside(track: Track, x: float, y: float) -> bool:
    """Farther from the centerline than the walls are there."""
    nearest, distance = _nearest(track, x, y)
    return bool(distance > max(track.width_left[nearest], track.width_right[nearest]))


def _looks_back(track: Track, x: float, y: float, yaw: float) -> bool:
    """Whether that heading is more than 90 degrees off the track's."""
    along = track.start_pose(float(track.stations[_nearest(track, x, y)[0]]))[2]
    return math.cos(yaw - along) < 0.0


def scenery_of(track: Track) -> Scenery:
    """What stands still on a track."""
    return Scenery(tuple(track.walls), tuple(track.visible), track.centerline)
