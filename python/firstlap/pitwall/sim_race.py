"""A race that does what it is told while it runs. Here it is only stepped; time and messages are `sim_process`'s."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from time import perf_counter_ns, thread_time_ns

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import ProgressCallback, SetsStart, driver_kind
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup
from firstlap.drivers.driving import Driving
from firstlap.pitwall.conditions import Conditions
from firstlap.pitwall.frame import DrivenLap, Frame, Pose
from firstlap.pitwall.lap_setup import LapSetup
from firstlap.pitwall.sim_laps import DrivenLine, with_lap
from firstlap.sim.lidar import core_track
from firstlap.sim.race_process import PackedCar, unpacked
from firstlap.tracks.track import Track

CAR = 0
INSTANT = 1e-9
"""[s] Two times that are nearer are the same."""
STOPPED = "emergency stop"
HEARD = 120
"""Scans for which what just happened is said."""


@dataclass(frozen=True)
class Plan:
    """What a race begins with; pickles. values: of the conditions, by key. going: whether it drives at once."""

    track: Track
    car: PackedCar
    setup: Setup
    seed: int
    values: dict[str, Value] = field(default_factory=dict)
    going: bool = True


@dataclass(frozen=True)
class CarSnapshot:
    """The car when the driver was last given a scan; as of `Frame`."""

    time: float
    pose: Pose
    speed: float
    yaw_rate: float
    steering_angle: float
    way: float
    offset: float
    clearance: float


def make_world(track: Track, car: Car, conditions: Conditions, seed: int) -> _core.World:
    """One car on the line. Raises InputError where it cannot start."""
    options = _core.WorldOptions()
    options.set("world", "mu_scale", conditions.friction)
    options.set("world", "command_timeout", 0.0)  # no mux: the race itself sees to the commands
    try:
        return _core.World(core_track(track), conditions.car(), options, seed)
    except ValueError as error:
        raise InputError(f"{track.name} with car {car.name}: {error}") from None


class SimRace:
    """One car, driven scan by scan. `number` changes when there is something new to be shown.

    The driver computes over one scan at a time, as in `firstlap race`: while it is busy the newest scan waits, and its
    command comes when it is done. It has no driver before `set_setup`. Raises InputError where it cannot begin.
    """

    def __init__(self, plan: Plan) -> None:
        self.track, self.car, self.seed = plan.track, unpacked(plan.car), plan.seed
        self.conditions = Conditions(self.car)
        for key, value in plan.values.items():
            self.conditions.set(key, value)
        self.world = make_world(self.track, self.car, self.conditions, self.seed)
        self.period = float(self.world.period)
        self.going, self.number, self.epoch = plan.going, 0, 0
        self.laps: tuple[DrivenLap, ...] = ()
        self.times: deque[tuple[float, float]] = deque(maxlen=8000)
        self._line, self._lap_setup, self._counted, self._hit = DrivenLine(), LapSetup(), 0, ""
        self._began = self.world.time
        self._event, self._event_until = "", 0
        self._commands: deque[tuple[float, float, float]] = deque()
        self._steering = self._busy_until = self._step_us = 0.0
        self._scan = self._driven_scan = 0
        self.driving: Driving | None = None
        self._snapshot = self._now()

    # What it is told.

    def set_setup(self, setup: Setup, preparing: ProgressCallback | None = None) -> None:
        """Another setup, maybe of another driver; one that needs a map begins anew at the line. Raises InputError, and
        then the one before drives on."""
        kind = driver_kind(setup.driver)
        if kind.needs_map:
            preparation = kind.prepare(self.track, setup, self.car, self.seed, preparing)
            self.driving = Driving(setup, self.car, preparation)
            self.world.reset(CAR)
            self._begin()
            self.say(f"driver {kind.name} begins at the line")
        elif self.driving is not None and self.driving.setup.driver == setup.driver:
            self.driving.take(setup)
        else:
            self.driving = Driving(setup, self.car)
            self.driving.reset()
        self._lap_setup.by(setup)
        self.number += 1

    def set_condition(self, key: str, value: Value) -> None:
        """One of the conditions, from now on. Raises InputError."""
        self.conditions.set(key, value)
        try:
            self.world.change(self.conditions.car(), self.conditions.friction)
        except ValueError as error:
            raise InputError(str(error)) from None

    def stop(self, since: float = 0.0) -> None:
        """Speed 0 from now on, `since` [s] after the last scan; the wheels go on steering until the car stands."""
        self.going = False
        self.world.command(CAR, 0.0, self._steering, since)
        self.number += 1

    def go(self) -> None:
        """Drives on, where nothing was touched."""
        self.going = True
        self.number += 1

    def restart(self) -> None:
        """Back to the line, at rest; laps begin anew."""
        self.world.reset(CAR)
        self._tell_place(0.0)
        self.laps = ()
        self.epoch += 1
        self._begin()

    def place(self, pose: Pose) -> None:
        """The car stands there, at rest. Raises InputError where it cannot."""
        if not self.world.fits(CAR, *pose):
            raise InputError(f"the car does not fit at x = {pose[0]:.2f} m, y = {pose[1]:.2f} m: it would touch a wall")
        self.world.place(CAR, *pose)
        self._tell_place(self.world.truth(CAR)["s"] / self.track.length)
        self._begin()

    def _tell_place(self, share: float) -> None:
        """To a driver with a map of the track: roughly, as who put the car down knows it."""
        if self.driving is not None and isinstance(self.driving.handle, SetsStart):
            self.driving.handle.set_start(share)

    def _begin(self) -> None:
        self._line.clear()
        self._lap_setup.begin()
        self._commands.clear()
        self._counted, self._hit, self._began = 0, "", self.world.time
        self._steering = self._busy_until = 0.0
        if self.driving is not None:
            self.driving.reset()
        self.say("")

    def say(self, text: str) -> None:
        """What just happened; the frames say it for a while."""
        self._event, self._event_until = text, self._scan + HEARD
        self.number += 1

    @property
    def said(self) -> str:
        """Why the car does not drive, and what just happened."""
        why = self._hit or ("" if self.going else STOPPED)
        return "; ".join(text for text in (why, self._event) if text)

    # What it does.

    def tick(self) -> None:
        """One scan period."""
        self.world.advance()
        self._scan += 1
        self._follow()
        now = self.world.time
        if self._busy_until <= now + self.period + INSTANT:  # free while this scan is still the newest
            self._drive(now)
        self._deliver(now)

    def _follow(self) -> None:
        """Laps and contacts."""
        truth = self.world.truth(CAR)
        self._line.add(truth["x"], truth["y"], truth["speed"])
        if self.world.laps_done(CAR) > self._counted:
            self._counted += 1
            lap = self.world.laps(CAR)[-1]
            self._count(lap.time, lap.min_clearance, lap.standing)
        if self.world.contacts(CAR) and not self._hit:
            self._hit = f"contact at {truth['s']:.1f} m: place the car or restart"
            self.number += 1
        if self._event and self._scan >= self._event_until:
            self.say("")

    def _count(self, time: float, clearance: float, standing: bool) -> None:
        number = self.laps[-1].number + 1 if self.laps else 1
        self.laps = with_lap(self.laps, self._lap_setup.sign(self._line.take(number, time, clearance, standing)))
        self._began = self.world.time
        self.say(f"lap {number} in {time:.3f} s, {clearance:.2f} m to the wall")

    def _drive(self, now: float) -> None:
        """The driver's step over this scan, begun as soon as it has both time and scan."""
        self._snapshot = self._now()
        self.number += 1
        if self.driving is None:
            return
        scan = self.world.scan(CAR)
        speed, yaw_rate, steering_angle = self.world.measured(CAR)
        dt = self.period * (self._scan - self._driven_scan)
        self._driven_scan = self._scan
        wall, cpu = perf_counter_ns(), thread_time_ns()
        command = self.driving.step(scan, speed, yaw_rate, steering_angle, dt)
        self._step_us = 1e-3 * (thread_time_ns() - cpu)
        self.times.append((self._step_us, 1e-3 * (perf_counter_ns() - wall)))
        self._check_driver(self.driving.handle.core)
        self._busy_until = max(self._busy_until, now) + self.conditions.computing
        self._commands.append((self._busy_until, command.speed, command.steering_angle))

    def _check_driver(self, core: _core.Driver) -> None:
        if not isinstance(core, _core.CallbackDriver):
            return
        try:
            core.raise_error()
        except Exception as error:
            self.going = False
            self.say(f"the driver failed: {error}")

    def _now(self) -> CarSnapshot:
        truth = self.world.truth(CAR)
        speed, yaw_rate, steering_angle = self.world.measured(CAR)
        return CarSnapshot(
            time=self.world.time,
            pose=(truth["x"], truth["y"], truth["yaw"]),
            speed=speed,
            yaw_rate=yaw_rate,
            steering_angle=steering_angle,
            way=truth["s"],
            offset=truth["lateral_offset"],
            clearance=self.world.lap_clearance(CAR),
        )

    def _deliver(self, now: float) -> None:
        """The commands that are due before the next scan."""
        if not self.going:
            self.world.command(CAR, 0.0, self._steering, 0.0)
        while self._commands and self._commands[0][0] < now + self.period - INSTANT:
            due, speed, self._steering = self._commands.popleft()
            self.world.command(CAR, speed if self.going else 0.0, self._steering, max(due - now, 0.0))

    # What it shows.

    def frame(self) -> Frame:
        """The newest, without its laps; its trace is empty before the first step."""
        seen, driving = self._snapshot, self.driving
        return Frame(
            number=self.number,
            time=seen.time,
            pose=seen.pose,
            speed=seen.speed,
            yaw_rate=seen.yaw_rate,
            steering_angle=seen.steering_angle,
            driver=driving.kind.name if driving else "",
            trace=driving.handle.trace if driving and self._driven_scan else {},
            step_us=self._step_us,
            way=seen.way,
            offset=seen.offset,
            clearance=seen.clearance if math.isfinite(seen.clearance) else None,
            began=min(self._began, seen.time),
            going=self.going and not self._hit,
            said=self.said,
            sent=None if self.going else (0.0, self._steering),
        )
