"""The map-based driver: one scan and noisy odometry in, one command out."""

from __future__ import annotations

import math
from time import thread_time
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.setup_file import load_setup
from firstlap.control.mpc.controller import Controller, Step
from firstlap.control.mpc.observer import finite
from firstlap.drivers.global_driver.guard import Guard, returns, way_ahead
from firstlap.drivers.global_driver.params import Parts
from firstlap.drivers.global_driver.prepare import MAPPING_SETUP, Prepared
from firstlap.drivers.global_driver.relocalization import Relocalization
from firstlap.localization.localizer import Estimate, Localizer, ScanHeader
from firstlap.mapping.alignment import align
from firstlap.mapping.observation import motion_of
from firstlap.mapping.poses import between, compose
from firstlap.planning.raceline.corridor import Corridor
from firstlap.planning.raceline.line import check_clear
from firstlap.tracks.track import FloatArray, Track

Pose = tuple[float, float, float]
Command = tuple[float, float, str]
SEED = 1
STOPS = ("no_path", "bad_state")
SURE = 2.0
"""[m/s] A car faster than this was localized."""


class GlobalDriver:
    """Localization, predictive control and the guard, as called by `_core.CallbackDriver`.

    status: ok; holding: no pose, or no plan in time: the last plan is followed; no_path: lost, or no plan for too
    long: the car stops along the free path in the scan; blocked: returns block the plan.
    """

    def __init__(self, parts: Parts, car: Car, prepared: Prepared) -> None:
        """Raises InputError if the car touches a wall of the map on the line."""
        self.parts, self.prepared = parts, prepared
        check_clear(prepared.line, Corridor(prepared.walls, car), prepared.line.source)
        self.localizer = Localizer(prepared.known, car, SEED, parts.localizer)
        # The time limit uses this thread's CPU time: other load on the machine does not delay plans.
        self.controller = Controller(prepared.line, prepared.walls, car, parts.mpc, clock=thread_time)
        self.guard = Guard(parts.guard, car, self.controller.model)
        path = prepared.line.path
        self._anywhere = Relocalization(parts.guard, prepared.known.field(), path.points, path.heading)
        self._by_scan = _core.Racer(load_setup(MAPPING_SETUP).params(car.core))
        self._race: _core.Race | None = None
        self._frame: FloatArray | None = None
        self._start: Pose = prepared.known.start or (0.0, 0.0, 0.0)
        self.reset()

    def reset(self) -> None:
        """Resets everything: the car is at the given start, or at the map's start."""
        self.localizer.start(self._start)
        self.controller.reset()
        self.guard.reset()
        self._anywhere.rest()
        self._known_way, self._map_fits = 0.0, False
        self._by_scan.reset()
        self._lost_for = 0.0
        self._on_scan = False
        self._previous_steering = 0.0
        self.estimate: Estimate | None = None
        self.seen: dict[str, Any] = {}

    def set_start(self, share: float) -> None:
        """Where the car is put down, as a share of a lap after the map's start: known as people know it, roughly."""
        walls, share = self.prepared.walls, share % 1.0
        self._start = walls.start_pose(share * walls.length) if share else self.prepared.known.start or self._start
        self.reset()

    def use_true_pose(self, race: _core.Race | None, track: Track) -> None:
        """For ablation: uses the simulator's pose, aligned with the map by the best fit of its walls."""
        self._race = race if self.parts.guard.true_pose else None
        if self._race is not None:
            self._frame = align(self.prepared.known, track, self._race.pose)

    def step(
        self,
        ranges: npt.NDArray[np.float32],
        speed: float,
        yaw_rate: float,
        steering_angle: float,
        dt: float,
        header: dict[str, float],
    ) -> Command:
        """One command. Does not raise for invalid data."""
        head = ScanHeader(**header)
        pose = self._pose(ranges, (speed, yaw_rate, steering_angle), dt, head)
        # From here on speeds are true speeds, scaled by the distance on the map; the command is scaled back.
        speed *= self.estimate.speed_scale if self.estimate is not None else 1.0
        if self.seen and self.seen["result"][2] == "blocked":
            pose = self._reckoned(speed, yaw_rate, dt) or pose
        self._meet(pose)
        self.controller.braking = self.guard.braking
        step = self.controller.step(pose, speed, yaw_rate, steering_angle, dt)
        good = finite((speed, yaw_rate, steering_angle), 100.0)
        v, r = (max(0.0, speed), yaw_rate) if good else (0.0, 0.0)
        command = self._checked(step, ranges, head, v, r)
        if pose is None or step.status in STOPS:
            self._lost_for += dt if math.isfinite(dt) else 0.0
            command = self._without_pose(step, command, ranges, (speed, yaw_rate, steering_angle), dt, head)
        else:
            self._lost_for, self._on_scan = 0.0, False
        self._seek(pose, ranges, head, speed, dt)
        if command[:2] != step[:2]:
            self.controller.replace(command[0], command[1])
        self._previous_steering = command[1]
        command = self._for_the_car(command)
        self.seen = {"ranges": ranges, "header": head, "result": command, "pose": pose}
        return command

    def _for_the_car(self, command: Command) -> Command:
        """The command scaled for the car: one that drives faster than commanded gets a lower command."""
        if self.estimate is None:
            return command
        speed = command[0] / self.estimate.command_scale
        self.localizer.commanded(speed)
        return speed, command[1], command[2]

    # The pose.

    def _pose(
        self, ranges: npt.NDArray[np.float32], state: tuple[float, float, float], dt: float, head: ScanHeader
    ) -> Pose | None:
        if self._race is not None and self._frame is not None:
            x, y, yaw = between(self._frame, np.array(self._race.pose))
            return float(x), float(y), float(yaw)
        self.estimate = found = self.localizer.step(ranges, *state, dt, head)
        self._map_fits = self._map_fits or (not found.lost and found.fit >= self.parts.guard.start_fit)
        return (found.x, found.y, found.yaw) if self._map_fits and not found.lost else None

    def _reckoned(self, speed: float, yaw_rate: float, dt: float) -> Pose | None:
        """The pose by odometry during a stop, since objects that are not in the map mislead the filter."""
        body = self.controller.body
        if body is None or not finite((speed, yaw_rate, dt), 100.0):
            return None
        x, y, yaw = compose(np.array(body[:3]), motion_of(speed, yaw_rate, dt)).tolist()
        return x, y, yaw

    def _seek(
        self, pose: Pose | None, ranges: npt.NDArray[np.float32], head: ScanHeader, speed: float, dt: float
    ) -> None:
        """Relocalizes a lost, stopped car on the whole map, since the filter searches only nearby.

        Only if the car has driven on this map before: parts of other tracks look similar.
        """
        if pose is not None:
            self._known_way += max(0.0, speed * dt) if math.isfinite(speed * dt) else 0.0
            if speed > SURE:
                self._anywhere.rest()
            return
        if self._known_way < self.prepared.line.length:
            return
        seen = returns(ranges, head, 0.0, 0.0, self.guard.body, head.range_max)
        found = self._anywhere.look(seen, speed, dt)
        if found is not None:
            self.localizer.start(found)

    def _meet(self, pose: Pose | None) -> None:
        """Resets the controller if the pose is far from the expected one."""
        body = self.controller.body
        if pose is None or body is None:
            return
        if math.hypot(pose[0] - body[0], pose[1] - body[1]) > self.parts.guard.jump:
            self.controller.reset()
            self.guard.reset()

    # The net.

    def _checked(
        self, step: Step, ranges: npt.NDArray[np.float32], head: ScanHeader, speed: float, yaw_rate: float
    ) -> Command:
        """The command, or braking if returns block the plan."""
        plan, body = self.controller.plan, self.controller.body
        if plan is None or body is None or step.status in STOPS:
            self.guard.reset()
            return step.speed, step.steering_angle, step.status
        way = way_ahead(plan, self.controller.table, body[:3], self.guard.reach(speed))
        reach = self.guard.body.front + float(np.hypot(*way[:, :2].T).max())
        self.guard.look(way, returns(ranges, head, speed, yaw_rate, self.guard.body, reach))
        command, blocked = self.guard.before_block(*self.controller.acting, yaw_rate, step.speed)
        return command, step.steering_angle, "blocked" if blocked else step.status

    def _without_pose(
        self,
        step: Step,
        command: Command,
        ranges: npt.NDArray[np.float32],
        state: tuple[float, float, float],
        dt: float,
        head: ScanHeader,
    ) -> Command:
        """Brakes: first along the plan, then along the free path in the scan."""
        yaw_rate = state[1] if math.isfinite(state[1]) else 0.0
        slower = min(command[0], self.guard.stopping(self.controller.acting[0], yaw_rate))
        if self._lost_for <= self.parts.guard.lost_pause and step.status not in STOPS:
            return slower, step.steering_angle, command[2] if command[2] == "blocked" else "holding"
        if not self._on_scan:
            self._by_scan.reset()
            self._on_scan = True
        by_scan = self._by_scan.step(ranges, *state, dt, *head)
        status = by_scan[2] if by_scan[2] in ("bad_scan", "bad_state") else "no_path"
        seen = by_scan[2] in ("ok", "holding")
        steering = by_scan[1] if seen else self._previous_steering
        return min(slower, by_scan[0]) if seen else slower, steering, status


class GlobalHandle:
    """The driver handle for races."""

    def __init__(self, parts: Parts, car: Car, prepared: Prepared) -> None:
        self.driver = GlobalDriver(parts, car, prepared)
        self.core: _core.Driver = _core.CallbackDriver(self.driver)

    def set_start(self, share: float) -> None:
        """Where it will be put down, as a share of a lap after the start line."""
        self.driver.set_start(share)

    def use_true_pose(self, race: _core.Race | None, track: Track) -> None:
        """For ablation; called before the first step and after the last."""
        self.driver.use_true_pose(race, track)

    @property
    def trace(self) -> dict[str, Any]:
        """The trace of the last step, see `global_driver.trace`."""
        from firstlap.drivers.global_driver.trace import trace_of

        return trace_of(self.driver)
