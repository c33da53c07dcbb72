"""An interactive race, stepped scan by scan; `sim_process` handles time and messages."""

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
TIME_TOLERANCE = 1e-9
"""[s] Tolerance for comparing times."""
STOPPED = "emergency stop"
EVENT_SCANS = 120
"""Number of scans for which an event is shown."""


@dataclass(frozen=True)
class Plan:
    """The start conditions of a race; picklable. values: of the conditions, by key. may_drive: initially."""

    track: Track
    car: PackedCar
    setup: Setup
    seed: int
    values: dict[str, Value] = field(default_factory=dict)
    may_drive: bool = True


@dataclass(frozen=True)
class CarSnapshot:
    """The car's state at the driver's last scan; fields as in `Frame`."""

    time: float
    pose: Pose
    speed: float
    yaw_rate: float
    steering_angle: float
    distance: float
    offset: float
    clearance: float


def make_world(track: Track, car: Car, conditions: Conditions, seed: int) -> _core.World:
    """A world with one car on the start line. Raises InputError if it cannot start."""
    options = _core.WorldOptions()
    options.set("world", "mu_scale", conditions.friction)
    options.set("world", "command_timeout", 0.0)  # no command timeout: the race itself sends all commands
    try:
        return _core.World(core_track(track), conditions.car(), options, seed)
    except ValueError as error:
        raise InputError(f"{track.name} with car {car.name}: {error}") from None


class SimRace:
    """One car, driven scan by scan. `number` changes when there is something new to show.

    The driver processes one scan at a time, as in `firstlap race`: while it is busy, the newest scan waits, and its
    command takes effect when it is done. There is no driver before `set_setup`. Raises InputError if the race cannot
    start.
    """

    def __init__(self, plan: Plan) -> None:
        self.track, self.car, self.seed = plan.track, unpacked(plan.car), plan.seed
        self.conditions = Conditions(self.car)
        for key, value in plan.values.items():
            self.conditions.set(key, value)
        self.world = make_world(self.track, self.car, self.conditions, self.seed)
        self.period = float(self.world.period)
        self.may_drive, self.number, self.epoch = plan.may_drive, 0, 0
        self.laps: tuple[DrivenLap, ...] = ()
        self.times: deque[tuple[float, float]] = deque(maxlen=8000)
        self._line, self._lap_setup, self._counted, self._hit = DrivenLine(), LapSetup(), 0, ""
        self._lap_start = self.world.time
        self._event, self._event_until = "", 0
        self._commands: deque[tuple[float, float, float]] = deque()
        self._steering = self._busy_until = self._step_us = 0.0
        self._scan = self._driven_scan = 0
        self.driving: Driving | None = None
        self._snapshot = self._now()

    # Requests.

    def set_setup(self, setup: Setup, preparing: ProgressCallback | None = None) -> None:
        """Changes the setup, possibly to another driver. A driver that needs a map restarts at the line. Raises
        InputError; then the previous setup stays."""
        kind = driver_kind(setup.driver)
        if kind.needs_map:
            preparation = kind.prepare(self.track, setup, self.car, self.seed, preparing)
            self.driving = Driving(setup, self.car, preparation)
            self.world.reset(CAR)
            self._begin()
            self.report(f"driver {kind.name} starts at the line")
        elif self.driving is not None and self.driving.setup.driver == setup.driver:
            self.driving.take(setup)
        else:
            self.driving = Driving(setup, self.car)
            self.driving.reset()
        self._lap_setup.by(setup)
        self.number += 1

    def set_condition(self, key: str, value: Value) -> None:
        """Changes a condition. Raises InputError."""
        self.conditions.set(key, value)
        try:
            self.world.change(self.conditions.car(), self.conditions.friction)
        except ValueError as error:
            raise InputError(str(error)) from None

    def stop(self, since: float = 0.0) -> None:
        """Commands speed 0, `since` [s] after the last scan; the driver keeps steering until the car has stopped."""
        self.may_drive = False
        self.world.command(CAR, 0.0, self._steering, since)
        self.number += 1

    def go(self) -> None:
        """Lets the car drive, unless it has touched a wall."""
        self.may_drive = True
        self.number += 1

    def restart(self) -> None:
        """Restarts at the line, at rest, with an empty lap list."""
        self.world.reset(CAR)
        self._set_driver_start(0.0)
        self.laps = ()
        self.epoch += 1
        self._begin()

    def place(self, pose: Pose) -> None:
        """Places the car, at rest. Raises InputError if it would touch a wall."""
        if not self.world.fits(CAR, *pose):
            raise InputError(f"the car does not fit at x = {pose[0]:.2f} m, y = {pose[1]:.2f} m: it would touch a wall")
        self.world.place(CAR, *pose)
        self._set_driver_start(self.world.truth(CAR)["s"] / self.track.length)
        self._begin()

    def _set_driver_start(self, share: float) -> None:
        """Gives a driver with a map the approximate start position, as a fraction of the lap."""
        if self.driving is not None and isinstance(self.driving.handle, SetsStart):
            self.driving.handle.set_start(share)

    def _begin(self) -> None:
        self._line.clear()
        self._lap_setup.begin()
        self._commands.clear()
        self._counted, self._hit, self._lap_start = 0, "", self.world.time
        self._steering = self._busy_until = 0.0
        if self.driving is not None:
            self.driving.reset()
        self.report("")

    def report(self, text: str) -> None:
        """Shows an event in the frames for a while."""
        self._event, self._event_until = text, self._scan + EVENT_SCANS
        self.number += 1

    @property
    def message(self) -> str:
        """Why the car does not drive, and the latest event."""
        reason = self._hit or ("" if self.may_drive else STOPPED)
        return "; ".join(text for text in (reason, self._event) if text)

    # Simulation.

    def tick(self) -> None:
        """Simulates one scan period."""
        self.world.advance()
        self._scan += 1
        self._follow()
        now = self.world.time
        if self._busy_until <= now + self.period + TIME_TOLERANCE:  # free while this scan is the newest
            self._drive(now)
        self._deliver(now)

    def _follow(self) -> None:
        """Checks for laps and contacts."""
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
            self.report("")

    def _count(self, time: float, clearance: float, standing: bool) -> None:
        number = self.laps[-1].number + 1 if self.laps else 1
        self.laps = with_lap(self.laps, self._lap_setup.sign(self._line.finish(number, time, clearance, standing)))
        self._lap_start = self.world.time
        self.report(f"lap {number} in {time:.3f} s, {clearance:.2f} m to the wall")

    def _drive(self, now: float) -> None:
        """Runs the driver's step on this scan; it starts once both driver and scan are available."""
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
            self.may_drive = False
            self.report(f"the driver failed: {error}")

    def _now(self) -> CarSnapshot:
        truth = self.world.truth(CAR)
        speed, yaw_rate, steering_angle = self.world.measured(CAR)
        return CarSnapshot(
            time=self.world.time,
            pose=(truth["x"], truth["y"], truth["yaw"]),
            speed=speed,
            yaw_rate=yaw_rate,
            steering_angle=steering_angle,
            distance=truth["s"],
            offset=truth["lateral_offset"],
            clearance=self.world.lap_clearance(CAR),
        )

    def _deliver(self, now: float) -> None:
        """Applies the commands that are due before the next scan."""
        if not self.may_drive:
            self.world.command(CAR, 0.0, self._steering, 0.0)
        while self._commands and self._commands[0][0] < now + self.period - TIME_TOLERANCE:
            due, speed, self._steering = self._commands.popleft()
            self.world.command(CAR, speed if self.may_drive else 0.0, self._steering, max(due - now, 0.0))

    # Output.

    def frame(self) -> Frame:
        """The newest frame, without laps; its trace is empty before the first step."""
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
            distance=seen.distance,
            offset=seen.offset,
            clearance=seen.clearance if math.isfinite(seen.clearance) else None,
            lap_start=min(self._lap_start, seen.time),
            may_drive=self.may_drive and not self._hit,
            message=self.message,
            sent=None if self.may_drive else (0.0, self._steering),
        )
