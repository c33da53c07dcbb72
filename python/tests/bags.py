"""Writes small recordings for the tests, with the library `rosbags`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

from firstlap.recordings import Recording
from firstlap.recordings.messages import ACKERMANN, typestore

SCAN, ODOM, IMU = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu"
DRIVE = f"{ACKERMANN}Stamped"
TF, POSE, FLOAT = "tf2_msgs/msg/TFMessage", "geometry_msgs/msg/PoseStamped", "std_msgs/msg/Float64"
BEAMS, PERIOD, START = 271, 0.025, 1_700_000_000
SPEED = 1.5


class Entry(NamedTuple):
    """One message: topic, type, log time [ns], message."""

    topic: str
    type: str
    time: int
    message: Any


def make(kind: str, *values: Any, ros1: bool = False) -> Any:
    return typestore("ros1" if ros1 else "cdr").types[kind](*values)


def header(time: int, ros1: bool = False, frame: str = "laser") -> Any:
    stamp = make("builtin_interfaces/msg/Time", *divmod(time, 1_000_000_000))
    return make("std_msgs/msg/Header", *((0,) if ros1 else ()), stamp, frame, ros1=ros1)


def nanoseconds(index: int) -> int:
    return START * 1_000_000_000 + round(index * PERIOD * 1e9)


def corridor(beams: int = BEAMS, width: float = 2.0, seed: int = 0) -> np.ndarray:
    """Ranges in the middle of a corridor, with a little noise."""
    angles = np.linspace(-0.75 * np.pi, 0.75 * np.pi, beams)
    with np.errstate(divide="ignore"):
        exact = np.minimum(0.5 * width / np.abs(np.sin(angles)), 25.0)
    return (exact + np.random.default_rng(seed).normal(0.0, 0.005, beams)).astype(np.float32)


def scan(time: int, ranges: np.ndarray, ros1: bool = False, beams_by_header: int | None = None) -> Any:
    count = beams_by_header or len(ranges)
    step = 1.5 * np.pi / (count - 1)
    none = np.zeros(0, dtype=np.float32)
    return make(
        SCAN, header(time, ros1), -0.75 * np.pi, 0.75 * np.pi, step, 0.0, PERIOD, 0.02, 30.0, ranges, none, ros1=ros1
    )  # fmt: skip


def odometry(time: int, speed: float, yaw_rate: float = 0.0, ros1: bool = False) -> Any:
    pose = make("geometry_msgs/msg/Pose", make("geometry_msgs/msg/Point", speed * (time / 1e9 - START), 0.0, 0.0),
                make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0))  # fmt: skip
    twist = make("geometry_msgs/msg/Twist", make("geometry_msgs/msg/Vector3", speed, 0.0, 0.0),
                 make("geometry_msgs/msg/Vector3", 0.0, 0.0, yaw_rate))  # fmt: skip
    return make(
        ODOM,
        header(time, ros1),
        "base_link",
        make("geometry_msgs/msg/PoseWithCovariance", pose, np.zeros(36)),
        make("geometry_msgs/msg/TwistWithCovariance", twist, np.zeros(36)),
        ros1=ros1,
    )


def pose(time: int, x: float, frame: str = "map") -> Any:
    """A geometry_msgs/PoseStamped with heading x."""
    there = make("geometry_msgs/msg/Point", x, 0.0, 0.0)
    return make(POSE, header(time, frame=frame), make("geometry_msgs/msg/Pose", there, quaternion(0.0, 0.0)))


def quaternion(yaw: float, roll: float) -> Any:
    """Quaternion of a roll [rad] followed by a yaw [rad]."""
    (c, s), (u, a) = ((np.cos(0.5 * angle), np.sin(0.5 * angle)) for angle in (yaw, roll))
    return make("geometry_msgs/msg/Quaternion", c * a, s * a, s * u, c * u)


def mounted(x: float, y: float, yaw: float, roll: float = 0.0, parent: str = "base_link", child: str = "laser") -> Any:
    """A tf2_msgs/TFMessage of one transform."""
    there = make("geometry_msgs/msg/Vector3", x, y, 0.11)
    transform = make("geometry_msgs/msg/Transform", there, quaternion(yaw, roll))
    return make(TF, [make("geometry_msgs/msg/TransformStamped", header(0, frame=parent), child, transform)])


def imu(time: int, yaw_rate: float | None, acceleration: tuple[float, float] | None = (0.0, 0.0)) -> Any:
    """yaw_rate, acceleration: None if the IMU measures none."""
    measured = make("geometry_msgs/msg/Vector3", *(acceleration or (0.0, 0.0)), 9.81)
    turn = make("geometry_msgs/msg/Vector3", 0.0, 0.0, yaw_rate or 0.0)
    level = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    turn_known, known = (np.full(9, -1.0 if value is None else 0.0) for value in (yaw_rate, acceleration))
    return make(IMU, header(time), level, np.zeros(9), turn, turn_known, measured, known)


def drive(time: int, speed: float, steering_angle: float, ros1: bool = False) -> Any:
    return make(DRIVE, header(time, ros1), make(ACKERMANN, steering_angle, 0.0, speed, 0.0, 0.0), ros1=ros1)


def entries(count: int = 60, *, ros1: bool = False, odom: bool = True, commands: bool = True) -> list[Entry]:
    """A drive along a corridor; stamps equal log times."""
    found = []
    for i in range(count):
        now = nanoseconds(i)
        found.append(Entry("/scan", SCAN, now, scan(now, corridor(seed=i), ros1)))
        if odom:
            found.append(Entry("/odom", ODOM, now, odometry(now, SPEED, 0.01, ros1)))
        if commands:
            found.append(Entry("/drive", DRIVE, now, drive(now, SPEED, 0.05, ros1)))
    return found


F1TENTH_SYSTEM = {
    "/scan": SCAN, "/odom": ODOM, "/drive": DRIVE, "/teleop": DRIVE, "/ackermann_drive": DRIVE,
    "/sensors/imu/raw": IMU, "/commands/motor/speed": FLOAT, "/commands/servo/position": FLOAT, "/tf_static": TF,
}  # fmt: skip
"""Topics recorded by f1tenth_system, from its launch files and mux."""
RACE_STACK = {
    "/scan": SCAN, "/car_state/odom": ODOM, "/car_state/odom_frenet": ODOM, "/vesc/odom": ODOM,
    "/early_fusion/odom": ODOM, "/car_state/pose": POSE, "/tracked_pose": POSE, "/initialpose": POSE,
    "/vesc/sensors/imu/raw": IMU, "/imu/data": IMU, "/vesc/low_level/ackermann_cmd_mux/output": DRIVE,
    "/vesc/low_level/ackermann_cmd_mux/input/teleop": DRIVE,
    "/vesc/low_level/ackermann_cmd_mux/input/navigation": DRIVE,
    "/vesc/high_level/ackermann_cmd_mux/output": DRIVE, "/vesc/high_level/ackermann_cmd_mux/input/nav_1": DRIVE,
    "/vesc/commands/servo/position": FLOAT, "/tf_static": TF,
}  # fmt: skip
"""Topics recorded by ForzaETH's race stack."""


def stack(topics: dict[str, str], count: int = 60) -> list[Entry]:
    """A drive along a corridor with these topics. Each has a different speed, angle or pose, to distinguish the
    topics."""
    found = []
    for i in range(count):
        now = nanoseconds(i)
        for index, (topic, kind) in enumerate(topics.items()):
            makes: dict[str, Callable[[], Any]] = {
                SCAN: lambda now=now, i=i: scan(now, corridor(seed=i)),
                ODOM: lambda now=now, index=index: odometry(now, SPEED + 0.01 * index),
                DRIVE: lambda now=now, index=index: drive(now, SPEED, 0.01 * index),
                IMU: lambda now=now, index=index: imu(now, 0.01 * index),
                POSE: lambda now=now, index=index, i=i: pose(now, 100.0 * index + SPEED * PERIOD * i),
                FLOAT: lambda index=index: make(FLOAT, 1000.0 * index),
                TF: lambda: mounted(0.27, 0.0, 0.0),
            }
            if kind != TF or i == 0:
                found.append(Entry(topic, kind, now, makes[kind]()))
    return found


def as_mounted(
    recording: Recording, mounting: tuple[float, ...], folder: Path, tf: bool = True, odom: bool = True
) -> Path:
    """The recording as a bag of a car with this LiDAR mounting: x, y [m], yaw, roll [degrees]."""
    x, y, yaw, roll = (*mounting[:2], *np.radians(mounting[2:]))
    items = [Entry("/tf_static", TF, 0, mounted(x, y, yaw, roll))] if tf else []
    for i, (ranges, state) in enumerate(zip(recording.ranges, recording.states, strict=True)):
        now, (first, step) = nanoseconds(i), recording.headers[i, :2]
        last = first + step * (len(ranges) - 1)
        first, last = (yaw - last, yaw - first) if roll else (first - yaw, last - yaw)
        message = scan(now, ranges[::-1].copy() if roll else ranges)
        message.angle_min, message.angle_max, message.angle_increment = first, last, step
        items.append(Entry("/scan", SCAN, now, message))
        items.append(Entry("/drive", DRIVE, now, drive(now, state[0], state[2])))
        if odom:
            items.append(Entry("/odom", ODOM, now, odometry(now, *state[:2])))
    return write_rosbag2(folder, items)


def write_rosbag2(
    path: Path, items: list[Entry], storage: str = "sqlite3", compression: CompressionMode | None = None
) -> Path:
    """A rosbag2 folder."""
    writer = Rosbag2Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections: dict[str, Any] = {}
        for item in items:
            if item.topic not in connections:
                connections[item.topic] = writer.add_connection(item.topic, item.type, typestore=typestore())
            data = typestore().serialize_cdr(item.message, item.type)
            writer.write(connections[item.topic], item.time, data)
    return path


def write_bag(path: Path, items: list[Entry]) -> Path:
    """A ROS 1 bag of several chunks."""
    store = typestore("ros1")
    writer = BagWriter(path)
    writer.chunk_threshold = 30_000
    with writer:
        connections: dict[str, Any] = {}
        for item in items:
            if item.topic not in connections:
                connections[item.topic] = writer.add_connection(item.topic, item.type, typestore=store)
            writer.write(connections[item.topic], item.time, store.serialize_ros1(item.message, item.type))
    return path


def _one_file(folder: Path, suffix: str) -> Path:
    return next(folder.glob(f"*{suffix}"))


WRITERS: dict[str, Callable[[Path], Path]] = {
    "folder of sqlite3": lambda path: write_rosbag2(path / "a", entries()),
    "folder of mcap": lambda path: write_rosbag2(path / "b", entries(), "mcap"),
    "db3": lambda path: _one_file(write_rosbag2(path / "c", entries()), ".db3"),
    "mcap": lambda path: _one_file(write_rosbag2(path / "d", entries(), "mcap"), ".mcap"),
    "bag": lambda path: write_bag(path / "e.bag", entries(ros1=True)),
    "packed as files": lambda path: write_rosbag2(path / "f", entries(), compression=CompressionMode.FILE),
    "packed as messages": lambda path: write_rosbag2(path / "g", entries(), compression=CompressionMode.MESSAGE),
    "packed as chunks": lambda path: write_rosbag2(path / "h", entries(), "mcap", CompressionMode.STORAGE),
}
