"""The map-based driver: one scan and noisy odometry in, one command out."""

from __future__ import annotations

import math
from time import thread_time
from typing import Any

import numpy as np

from firstlap import _core
from firstlap._core import Estimate
from firstlap.config.car_file import Car
from firstlap.config.setup_file import load_setup
from firstlap.control.mpc.controller import Controller, Step
from firstlap.control.mpc.observer import finite
from firstlap.drivers.global_driver.guard import Guard, returns, way_ahead
from firstlap.drivers.global_driver.params import Parts
from firstlap.drivers.global_driver.prepare import MAPPING_SETUP, Prepared
from firstlap.drivers.global_driver.relocalization import Relocalization
from firstlap.localization.localizer import Localizer
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

    def step(self, scan: _core.LaserScan, measured: _core.VehicleState, dt: float) -> Command:
        """One command. Does not raise for invalid data."""
        pose = self._pose(scan, measured, dt)
        state = self._true_speed(measured)
        if self.seen and self.seen["result"][2] == "blocked":
            pose = self._reckoned(state, dt) or pose
        self._meet(pose)
        self.controller.braking = self.guard.braking
        step = self.controller.step(pose, state, dt)
        command = self._checked(step, scan, state)
        if pose is None or step.status in STOPS:
            self._lost_for += dt if math.isfinite(dt) else 0.0
            command = self._without_pose(step, command, scan, state, dt)
        else:
            self._lost_for, self._on_scan = 0.0, False
        self._seek(pose, scan, state.speed, dt)
        if command[:2] != step[:2]:
            self.controller.replace(command[0], command[1])
        self._previous_steering = command[1]
        command = self._for_the_car(command)
        self.seen = {"scan": scan, "result": command, "pose": pose}
        return command

    def _true_speed(self, measured: _core.VehicleState) -> _core.VehicleState:
        """The state with the true speed, scaled by the distance on the map; `_for_the_car` scales the command back."""
        scale = self.estimate.speed_scale if self.estimate is not None else 1.0
        return _core.VehicleState(scale * measured.speed, measured.yaw_rate, measured.steering_angle)

    def _for_the_car(self, command: Command) -> Command:
        """The command scaled for the car: one that drives faster than commanded gets a lower command."""
        if self.estimate is None:
            return command
        speed = command[0] / self.estimate.command_scale
        self.localizer.commanded(speed)
        return speed, command[1], command[2]

    # The pose.

    def _pose(self, scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> Pose | None:
        if self._race is not None and self._frame is not None:
            x, y, yaw = between(self._frame, np.array(self._race.pose))
            return float(x), float(y), float(yaw)
        self.estimate = found = self.localizer.step(scan, state, dt)
        self._map_fits = self._map_fits or (not found.lost and found.fit >= self.parts.guard.start_fit)
        return (found.x, found.y, found.yaw) if self._map_fits and not found.lost else None

    def _reckoned(self, state: _core.VehicleState, dt: float) -> Pose | None:
        """Where odometry leads: what the map does not know draws the filter away, and the stop is short."""
        body = self.controller.body
        if body is None or not finite((state.speed, state.yaw_rate, dt), 100.0):
            return None
        x, y, yaw = compose(np.array(body[:3]), motion_of(state.speed, state.yaw_rate, dt)).tolist()
        return x, y, yaw

    def _seek(self, pose: Pose | None, scan: _core.LaserScan, speed: float, dt: float) -> None:
        """Lost and standing: the filter looks only nearby, so that where the car is must be found anew.

        Only if the car has driven on this map before: parts of other tracks look similar.
        """
        if pose is not None:
            self._known_way += max(0.0, speed * dt) if math.isfinite(speed * dt) else 0.0
            if speed > SURE:
                self._anywhere.rest()
            return
        if self._known_way < self.prepared.line.length:
            return
        seen = returns(scan, 0.0, 0.0, self.guard.body, scan.range_max)
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

    def _checked(self, step: Step, scan: _core.LaserScan, state: _core.VehicleState) -> Command:
        """The command, unless returns stand in the plan."""
        plan, body = self.controller.plan, self.controller.body
        good = finite(tuple(state), 100.0)
        speed, yaw_rate = (max(0.0, state.speed), state.yaw_rate) if good else (0.0, 0.0)
        if plan is None or body is None or step.status in STOPS:
            self.guard.reset()
            return step.speed, step.steering_angle, step.status
        way = way_ahead(plan, self.controller.table, body[:3], self.guard.reach(speed))
        reach = self.guard.body.front + float(np.hypot(*way[:, :2].T).max())
        self.guard.look(way, returns(scan, speed, yaw_rate, self.guard.body, reach))
        command, blocked = self.guard.before_block(*self.controller.acting, yaw_rate, step.speed)
        return command, step.steering_angle, "blocked" if blocked else step.status

    def _without_pose(
        self, step: Step, command: Command, scan: _core.LaserScan, state: _core.VehicleState, dt: float
    ) -> Command:
        """Brakes: first along the plan, then along the free path in the scan."""
        yaw_rate = state.yaw_rate if math.isfinite(state.yaw_rate) else 0.0
        slower = min(command[0], self.guard.stopping(self.controller.acting[0], yaw_rate))
        if self._lost_for <= self.parts.guard.lost_pause and step.status not in STOPS:
            return slower, step.steering_angle, command[2] if command[2] == "blocked" else "holding"
        if not self._on_scan:
            self._by_scan.reset()
            self._on_scan = True
        by_scan = self._by_scan.step(scan, state, dt)
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
