"""The simulator node: cars on a track, at a real-time factor, with the topics of a real car."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from ackermann_msgs.msg import AckermannDriveStamped
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, load_car, with_lidar
from firstlap.config.parameters import FieldTable
from firstlap.perception.scan import Mount, laser_of
from firstlap.ros import sim_messages as make
from firstlap.ros.names import FAULTS, SIM, Entry
from firstlap.ros.node_parameters import declare_entries, declare_fields, value_of
from firstlap.ros.sim_topics import GYM_LASER_X, CarNames, gym_names, our_names
from firstlap.sim.lidar import core_track
from firstlap.tracks.library import load_track

NAME = "firstlap_sim"
WORLD_FIELDS = FieldTable(_core.WorldOptions.fields())
MAX_LAG = 4.0
"""Lag in scan periods after which the lost time is skipped."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass
class CarTopics:
    """One car's publishers and their state."""

    names: CarNames
    scan: Any
    odom: Any
    truth: Any
    imu: Any
    joints: Any
    others: list[Any]
    pose: Any = None
    waiting: Any = None
    laps: int = 0
    contacts: int = 0


class SimNode(Node):
    """given: parameter defaults; ROS arguments override them. report: called for laps and contacts. Raises
    InputError."""

    def __init__(self, given: dict[str, Any] | None = None, report: Callable[[str], None] | None = None) -> None:
        super().__init__(NAME)
        given = given or {}
        try:
            declare_entries(self, [_with(entry, given) for entry in SIM])
            declare_entries(self, [_with(entry, given) for entry in FAULTS])
            declare_fields(self, WORLD_FIELDS.fields, lambda field: given.get(field.key, field.default))
        except ValueError as error:
            raise InputError(str(error)) from None
        self._report = report or self.get_logger().info
        self._build()
        self._rng = np.random.default_rng(value_of(self, "seed"))
        self._begin()

    # Setup.

    def _build(self) -> None:
        gym = bool(value_of(self, "gym_names"))
        self.factor = float(value_of(self, "factor"))
        self.clocked = bool(value_of(self, "publish_clock"))
        if self.factor != 1.0 and not self.clocked:
            raise InputError(f"factor {self.factor:g} needs publish_clock: other nodes need the time from /clock")
        self.track = load_track(value_of(self, "track"))
        if value_of(self, "reverse"):
            self.track = self.track.reversed()
        car = load_car(value_of(self, "car") or ("gym" if gym else "default"))
        self.car = with_lidar(car, value_of(self, "lidar") or None)
        if gym:
            self.car.core.set("geometry", "laser_x", GYM_LASER_X)
        options = _core.WorldOptions()
        for field in WORLD_FIELDS.fields:
            options.set(field.section, field.name, value_of(self, field.key))
        try:
            self.world = _core.World(core_track(self.track), self.car.core, options, int(value_of(self, "seed")))
        except ValueError as error:
            raise InputError(f"{self.track.name}: {error}") from None
        names = gym_names(len(self.world)) if gym else our_names(len(self.world), value_of(self, "namespaces"))
        self.period = self.world.period
        self.cars = [self._car_topics(i, name) for i, name in enumerate(names)]
        self._shared(gym)

    def _car_topics(self, index: int, names: CarNames) -> CarTopics:
        publish = self.create_publisher
        self.create_subscription(AckermannDriveStamped, names.drive, partial(self.on_drive, index), 1)
        self.create_service(Trigger, f"{names.prefix}reset", partial(self.on_reset, index))
        self.create_service(Trigger, f"{names.prefix}kick", partial(self.on_kick, index))
        start = self.world.truth(index)
        return CarTopics(
            names,
            publish(LaserScan, names.scan, qos_profile_sensor_data),
            publish(Odometry, names.odom, 10),
            publish(Odometry, f"{names.prefix}ground_truth/odom", 10),
            publish(Imu, f"{names.prefix}sensors/imu/raw", 10),
            publish(JointState, f"{names.prefix}joint_states", 10),
            [(publish(Odometry, topic, 10), other) for topic, other in names.others],
            pose=np.array([0.0, 0.0, 0.0]) if names.odom_frame != "map" else _pose(start),
        )

    def _shared(self, gym: bool) -> None:
        """Creates what all cars share: TF, /clock, the map and the reset service."""
        self.tf = self.create_publisher(TFMessage, "/tf", 100)
        self.tf_static = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self.clock = self.create_publisher(Clock, "/clock", 10) if self.clocked else None
        self.create_subscription(PoseWithCovarianceStamped, "initialpose", self.on_initial_pose, 1)
        if len(self.cars) > 1 or gym:
            self.create_service(Trigger, "~/reset", self.on_reset_all)
        mount = _mount(self.car)
        frames = [(wires.names.base_frame, wires.names.laser_frame) for wires in self.cars]
        self.tf_static.publish(TFMessage(transforms=[make.laser_place(base, laser, mount) for base, laser in frames]))
        self.map = self.create_publisher(OccupancyGrid, "/map", LATCHED)
        self.map.publish(make.occupancy(self.track))

    # Time.

    def _begin(self) -> None:
        self._wall = time.monotonic()
        self._stamp = self.get_clock().now().nanoseconds * 1e-9
        self._periods = 0
        self.given_up = 0.0
        self._delayed: deque[tuple[float, Any, Any]] = deque()

    @property
    def due(self) -> float:
        """Time of the next scan, as of time.monotonic()."""
        return self._wall + (self._periods + 1) * self.period / self.factor

    def stamp(self) -> float:
        """Stamp [s] of the last scan."""
        return float(self.world.time) if self.clocked else self._stamp + self._periods * self.period

    def tick_if_due(self) -> bool:
        """Simulates one scan period if it is due. Lost time is skipped, not caught up."""
        late = time.monotonic() - self.due
        if late < 0.0:
            return False
        if late > MAX_LAG * self.period / self.factor:
            self._wall += late
            self._stamp += late if not self.clocked else 0.0
            self.given_up += late
        self.world.advance()
        self._periods += 1
        self._publish()
        return True

    # In.

    def on_drive(self, index: int, message: Any) -> None:
        """Applies a command at its time of arrival."""
        since = (time.monotonic() - self.due) * self.factor + self.period
        self.world.command(index, message.drive.speed, message.drive.steering_angle, max(since, 0.0))

    def on_reset(self, index: int, request: Any, response: Any) -> Any:
        """reset: back to the start, at rest."""
        self.world.reset(index)
        self.cars[index].laps = self.cars[index].contacts = 0
        response.success, response.message = True, "at the start"
        return response

    def on_reset_all(self, request: Any, response: Any) -> Any:
        """~/reset: all cars."""
        for index in range(len(self.world)):
            self.on_reset(index, request, response)
        return response

    def on_kick(self, index: int, request: Any, response: Any) -> Any:
        """kick: disturbs the car's motion."""
        self.world.kick(index, value_of(self, "kick_lateral_speed"), value_of(self, "kick_yaw_rate"))
        response.success, response.message = True, "kicked"
        return response

    def on_initial_pose(self, message: Any) -> None:
        """Places the first car at the pose from rviz's 2D Pose Estimate, in the frame map."""
        self.world.place(0, *make.pose_of(message.pose.pose))

    # Out.

    def _publish(self) -> None:
        now = self.stamp()
        if self.clock:
            self.clock.publish(make.clock(now))
        stamp = now + value_of(self, "stamp_offset")
        if value_of(self, "backward_stamps"):
            stamp = 2.0 * self._stamp - stamp if not self.clocked else max(1e3 - stamp, 0.0)
        transforms = []
        for index, wires in enumerate(self.cars):
            measured = self.world.measured(index)
            self._move(wires, index, measured)
            transforms.append(make.transform(now, wires.names.odom_frame, wires.names.base_frame, wires.pose))
            self._publish_state(wires, index, measured, stamp)
            self._publish_scan(wires, index, stamp)
            self._report_events(wires, index)
        self.tf.publish(TFMessage(transforms=transforms))

    def _move(self, wires: CarTopics, index: int, measured: _core.VehicleState) -> None:
        """Updates the odometry pose: integrated from speed and yaw rate, or the true pose with gym names."""
        if wires.names.odom_frame == "map":
            wires.pose = _pose(self.world.truth(index))
            return
        speed, yaw_rate, _ = measured
        x, y, yaw = wires.pose
        middle = yaw + 0.5 * yaw_rate * self.period
        wires.pose = np.array(
            [
                x + speed * self.period * np.cos(middle),
                y + speed * self.period * np.sin(middle),
                yaw + yaw_rate * self.period,
            ]
        )

    def _publish_state(self, wires: CarTopics, index: int, measured: _core.VehicleState, stamp: float) -> None:
        names, truth = wires.names, self.world.truth(index)
        speed, yaw_rate, steering_angle = measured
        if not self._chance("drop_odometry"):
            if value_of(self, "freeze_odometry") and wires.waiting is not None:
                odometry = wires.waiting
            else:
                lost = float("nan") if value_of(self, "nan_odometry") else 0.0
                lateral = truth["lateral_speed"] if names.odom_frame == "map" else 0.0
                odometry = make.odometry(
                    stamp,
                    names.odom_frame,
                    names.base_frame,
                    wires.pose,
                    self._with_faults(wires.pose, (speed + lost, lateral, yaw_rate + lost)),
                )
            wires.waiting = odometry
            wires.odom.publish(odometry)
        if wires.imu.get_subscription_count() and not self._chance("drop_imu"):
            lost = float("nan") if value_of(self, "nan_imu") else 0.0
            reading = self.world.reading(index)
            acceleration = (reading.acceleration_x, reading.acceleration_y)
            wires.imu.publish(make.imu(stamp, names.base_frame, reading.yaw_rate + lost, acceleration))
        if wires.joints.get_subscription_count() and not self._chance("drop_steering"):
            wires.joints.publish(make.joints(stamp, steering_angle))
        if value_of(self, "ground_truth") and wires.truth.get_subscription_count():
            motion = (truth["speed"], truth["lateral_speed"], truth["yaw_rate"])
            wires.truth.publish(make.odometry(stamp, "map", names.base_frame, _pose(truth), motion))
        for publisher, other in wires.others:
            seen = self.world.truth(other)
            motion = (seen["speed"], seen["lateral_speed"], seen["yaw_rate"])
            publisher.publish(make.odometry(stamp, "map", self.cars[other].names.base_frame, _pose(seen), motion))

    def _with_faults(self, pose: Any, motion: tuple[float, float, float]) -> tuple[float, float, float]:
        """The twist with the injected odometry faults."""
        forward, left = value_of(self, "odometry_speed_scale") * motion[0], motion[1]
        yaw_rate = value_of(self, "odometry_yaw_rate_scale") * motion[2]
        if value_of(self, "odometry_in_map"):
            c, s = np.cos(pose[2]), np.sin(pose[2])
            forward, left = c * forward - s * left, s * forward + c * left
        return float(forward), float(left), float(yaw_rate)

    def _publish_scan(self, wires: CarTopics, index: int, stamp: float) -> None:
        if self._chance("drop_scans"):
            return
        scan = self.world.scan(index)
        ranges = scan.ranges
        beams = int(value_of(self, "scan_beams"))
        if beams:
            ranges = ranges[:beams]
        if value_of(self, "nan_scans"):
            ranges[:] = np.nan
        frame = value_of(self, "scan_frame") or wires.names.laser_frame
        header = (*self.world.own_angles(index), *scan.header[2:])
        message = make.scan(stamp, frame, ranges, header, self.period, bool(value_of(self, "end_stamps")))
        delay = value_of(self, "delay")
        if delay <= 0.0:
            wires.scan.publish(message)
        else:
            self._delayed.append((time.monotonic() + delay, wires.scan, message))

    def publish_late(self) -> float:
        """Publishes the delayed scans that are due. Returns the time of the next one, as of time.monotonic()."""
        late = self._delayed
        while late and late[0][0] <= time.monotonic():
            _, publisher, message = late.popleft()
            publisher.publish(message)
        return late[0][0] if late else float("inf")

    def _chance(self, name: str) -> bool:
        share = value_of(self, name)
        return share > 0.0 and bool(self._rng.random() < share)

    def _report_events(self, wires: CarTopics, index: int) -> None:
        laps, contacts = self.world.laps_done(index), self.world.contacts(index)
        car = wires.names.prefix.rstrip("/") or "car"
        if laps > wires.laps:
            lap = self.world.laps(index)[-1]
            self._report(f"{car}: lap {laps} in {lap.time:.3f} s, {lap.min_clearance:.2f} m to the wall")
        if contacts > wires.contacts:
            self._report(f"{car}: contact at {self.world.truth(index)['s']:.1f} m")
        wires.laps, wires.contacts = laps, contacts

    def summary(self) -> dict[str, Any]:
        """The result for `firstlap sim --json`."""
        cars = [
            {
                "name": wires.names.prefix.rstrip("/") or "car",
                "laps": [lap.to_dict() for lap in self.world.laps(index)],
                "contacts": self.world.contacts(index),
            }
            for index, wires in enumerate(self.cars)
        ]
        return {"track": self.track.name, "time": self.world.time, "time_given_up": self.given_up, "cars": cars}


def _mount(car: Car) -> Mount:
    values = car.core.values()
    lidar = values["lidar"]
    return Mount(*laser_of(values["geometry"]), float(lidar["yaw"]), bool(lidar["upside_down"]))


def _pose(truth: dict[str, float]) -> Any:
    return np.array([truth["x"], truth["y"], truth["yaw"]])


def _with(entry: Entry, given: dict[str, Any]) -> Entry:
    if entry.name not in given:
        return entry
    value = given[entry.name]
    return replace(entry, default=float(value) if isinstance(entry.default, float) else value)
