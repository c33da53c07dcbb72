"""A simulated race in a separate process, as a source of frames."""

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
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.mailbox import CLOSE, Mailbox, Message
from firstlap.pitwall.sim_laps import with_lap
from firstlap.pitwall.sim_process import PREPARING, run
from firstlap.pitwall.sim_race import CAR, Plan, make_world
from firstlap.pitwall.source_state import SourceState
from firstlap.sim.race_process import bare, packed
from firstlap.tracks.track import Track

REQUEST_PERIOD = 0.02
"""[s] Minimum period of frame requests."""
RESPONSE_TIMEOUT = 2.0
"""[s] Without a frame for this time, the viewers get a message, and a restart starts a new process."""
START_TIMEOUT = 20.0
"""[s] The same for the first frame."""
END_TIMEOUT = 0.5
"""[s] Time for the race to end on request, and again after each signal."""


class SimSource(SourceState):
    """A `Source` that `Drives` and `Simulates`. Raises InputError if the car cannot start on the track.

    track: in driving direction. pace: multiple of real time.
    """

    def __init__(self, track: Track, setup: Setup, car: Car, *, seed: int = 1, pace: float = 1.0) -> None:
        if not 0 <= seed < 2**63:
            raise InputError(f"seed is {seed}, outside of the allowed range 0 to 2^63 - 1")
        self.title = track.name
        self.track, self.car, self.seed = track, car, seed
        self.scenery = scenery_of(track)
        self._conditions = Conditions(car, checked_pace(pace))
        self._world = make_world(track, car, self._conditions, seed)
        self._check(setup)
        super().__init__(setup)
        self._may_drive, self._closed, self._silent = True, False, False
        self._lock = threading.RLock()
        self._laps: tuple[DrivenLap, ...] = ()
        self._epoch = -1
        self._race: _Race | None = None
        self._timing: tuple[Any, Any] | None = None
        self._timed = threading.Event()

    # Source.

    def start(self) -> None:
        """Starts the race, in its process."""
        with self._lock:
            if self._race is None and not self._closed:
                plan = Plan(
                    bare(self.track), packed(self.car), self._setup, self.seed, self._conditions.values, self._may_drive
                )
                self._epoch, self._silent = -1, False
                self._race = _Race(plan, self._on_message, self._died)

    def close(self) -> None:
        """Ends the race process."""
        with self._lock:
            self._closed = True
            race, self._race = self._race, None
        if race is not None:
            race.end()

    def change(self, values: Mapping[str, Value]) -> None:
        """Changes parameters by section.name, while driving."""
        with self._lock:
            self._take(changed_from(self._setup.with_values(values), self._loaded))

    def choose(self, setup: Setup) -> None:
        """Loads another setup. A driver that needs a map makes it first, and starts at the line."""
        with self._lock:
            self._take(setup)
            self._loaded = setup

    def _take(self, setup: Setup) -> None:
        self._check(setup)
        self._send("setup", setup)
        self._setup = setup

    def _check(self, setup: Setup) -> None:
        setup.validate(f"{setup.title} on car {self.car.name}", self.car.core)

    # Drives.

    def stop(self) -> None:
        """Emergency stop."""
        self._may_drive = False
        self._send("stop", may_fail=True)

    def go(self) -> None:
        """Lets the car drive."""
        self._may_drive = True
        self._send("go", may_fail=True)

    # Simulates.

    @property
    def conditions(self) -> FieldTable:
        """Conditions of the simulated car and world; the defaults are the loaded car's."""
        return self._conditions.table

    def condition(self, name: str) -> Value:
        """The current value of a condition."""
        return self._conditions.get(name)

    def set_condition(self, name: str, value: Value) -> None:
        """Changes a condition while driving."""
        with self._lock:
            before = self._conditions.get(name)
            key = self._conditions.set(name, value)
            try:
                self._send("condition", key, self._conditions.values[key])
            except InputError:
                self._conditions.set(key, before)
                raise

    def restart(self) -> None:
        """Restarts at the line, at rest, with an empty lap list; also if the race process has ended or hangs."""
        with self._lock:
            if self._silent and self._race is not None:
                silent, self._race = self._race, None
                silent.kill()
            if self._race is None:
                self.start()
                if self._frame:
                    self._show(self._frame, message="a new race starts")
            else:
                self._send("restart")

    def place(self, pose: Pose) -> None:
        """Places the car, at rest. Raises InputError if it is on or behind a wall, or if a driver with a map would face
        backward."""
        if not all(math.isfinite(value) for value in pose):
            raise InputError(f"the car cannot be placed at {pose}: expected x, y [m] and yaw [rad]")
        x, y, yaw = (float(value) for value in pose)
        if _outside(self.track, x, y):
            raise InputError(f"x = {x:.2f} m, y = {y:.2f} m is not on the track: choose a place between its walls")
        if driver_kind(self._setup.driver).needs_map and _faces_backward(self.track, x, y, yaw):
            raise InputError(f"driver {self._setup.driver} drives its line in one direction only: turn the car around")
        with self._lock:
            if not self._world.fits(CAR, x, y, yaw):
                raise InputError(f"the car does not fit at x = {x:.2f} m, y = {y:.2f} m: it would touch a wall")
            self._send("place", (x, y, yaw))

    # For measurements.

    def timing(self, patience: float = 2.0) -> tuple[Any, Any]:
        """Since the last call: step times by CPU and wall clock (N, 2) [us], and the scans' lag (M,) [us]. Raises
        InputError if the race does not respond."""
        self._timed.clear()
        self._send("timing")
        if not self._timed.wait(patience) or self._timing is None:
            raise InputError(f"{self.title}: the race does not respond")
        return self._timing

    # The race process.

    def _send(self, *message: Any, may_fail: bool = False) -> None:
        """Sends a message. Raises InputError if the race has ended."""
        race = self._race  # no lock: a stop must not wait
        if race is None and not (may_fail or self._frame is None):
            raise InputError("the race has ended: restart starts a new one")
        if race is not None:
            race.send(message)

    def _on_message(self, race: _Race, message: Message) -> Message:
        """Handles a message of the race; returns the request for the next frame. Ignores a race that was replaced."""
        with self._lock:
            if self._race is not race:
                return ("ask", -1, 0)
            return self._handle(message)

    def _handle(self, message: Message) -> Message:
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
            if not frame.message.startswith(PREPARING):
                self._silent = True
                self._show(frame, may_drive=False, message="the race does not respond: restart starts a new one")
        elif message[0] == "timing":
            self._timing = message[1:]
            self._timed.set()
        return ("ask", self._epoch, self._laps[-1].number if self._laps else 0)

    def _died(self, race: _Race, how: str) -> None:
        with self._lock:
            if self._race is not race:
                return
            self._race = None
            self._show(
                self._frame or _nothing(self._world), may_drive=False, message=f"the race has ended: {how}; restart"
            )

    def _show(self, frame: Frame, **changed: Any) -> None:
        self._number += 1
        self._frame = replace(frame, number=self._number, **changed)


class _Race:
    """The race process and the thread that receives its messages."""

    def __init__(self, plan: Plan, on_message: Any, died: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        their_life, self._life = context.Pipe(duplex=False)
        self.process: SpawnProcess = context.Process(
            target=run, args=(plan, theirs, their_life), name="firstlap race", daemon=True
        )
        self.process.start()
        theirs.close()
        their_life.close()
        self._on_message, self._died = on_message, died
        self._mailbox = Mailbox(self._connection)
        self._thread = threading.Thread(target=self._listen, name="race", daemon=True)
        self._thread.start()

    def send(self, message: Message) -> None:
        """Sends a message. Never blocks. Messages to an ended process are dropped; `died` was, or will be, called."""
        self._mailbox.put(message)

    def _listen(self) -> None:
        self.send(("ask", -1, 0))
        last = 0.0
        try:
            while True:
                while not self._connection.poll(RESPONSE_TIMEOUT if last else START_TIMEOUT):
                    self._on_message(self, ("silence",))
                message = self._connection.recv()
                answer = self._on_message(self, message)
                if message[0] == "frame":
                    sleep(max(0.0, last + REQUEST_PERIOD - monotonic()))
                    last = monotonic()
                    self.send(answer)
        except (EOFError, OSError):
            self.process.join(END_TIMEOUT)
            self._died(self, _how(self.process.exitcode))

    def kill(self) -> None:
        """Kills an unresponsive process."""
        self.process.kill()
        self.process.join(END_TIMEOUT)
        self._clean_up()

    def end(self) -> None:
        """Ends the process: on request, then by signals."""
        self.send((CLOSE,))
        self.process.join(END_TIMEOUT)
        for end in (self.process.terminate, self.process.kill):
            if self.process.is_alive():
                end()
                self.process.join(END_TIMEOUT)
        self._clean_up()

    def _clean_up(self) -> None:
        self.send((CLOSE,))  # ends the sending thread
        self._life.close()
        self._thread.join(END_TIMEOUT)


def _how(code: int | None) -> str:
    if code is None:
        return "its process does not answer"
    return f"its process was ended by signal {-code}" if code < 0 else f"its process ended with exit code {code}"


def _nothing(world: Any) -> Frame:
    start = world.truth(CAR)
    return Frame(0, 0.0, (start["x"], start["y"], start["yaw"]), 0.0, 0.0, 0.0, "", {}, 0.0)


def _nearest(track: Track, x: float, y: float) -> tuple[int, float]:
    """Index and distance [m] of the nearest centerline point."""
    distance = np.hypot(track.centerline[:, 0] - x, track.centerline[:, 1] - y)
    nearest = int(np.argmin(distance))
    return nearest, float(distance[nearest])


def _outside(track: Track, x: float, y: float) -> bool:
    """Whether a point is farther from the centerline than the walls are there."""
    nearest, distance = _nearest(track, x, y)
    return bool(distance > max(track.width_left[nearest], track.width_right[nearest]))


def _faces_backward(track: Track, x: float, y: float, yaw: float) -> bool:
    """Whether the heading is more than 90 degrees off the track's direction."""
    along = track.start_pose(float(track.stations[_nearest(track, x, y)[0]]))[2]
    return math.cos(yaw - along) < 0.0


def scenery_of(track: Track) -> Scenery:
    """The static surroundings of a track."""
    return Scenery(tuple(track.walls), tuple(track.visible), track.centerline)
