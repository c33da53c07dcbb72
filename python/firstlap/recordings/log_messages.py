"""The messages of our own logs: one function per topic that serializes a standard ROS message."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.recordings.cdr import NANOSECONDS, SECONDS, Template, mark
from firstlap.recordings.clock import sweep
from firstlap.recordings.messages import ACKERMANN, typestore
from firstlap.recordings.step_log import STATUSES

Floats = npt.NDArray[np.float64]

MAP, ODOM, BASE, LASER = "map", "odom", "base_link", "laser"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
JOINT_STATE = "sensor_msgs/msg/JointState"
DRIVE = f"{ACKERMANN}Stamped"
TF = "tf2_msgs/msg/TFMessage"
MARKER = "visualization_msgs/msg/Marker"
PATH = "nav_msgs/msg/Path"
POINT = "geometry_msgs/msg/PointStamped"
CLOUD = "sensor_msgs/msg/PointCloud2"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
ARRAY = "std_msgs/msg/Float64MultiArray"

NUMBERS = ("width", "ahead", "clearance", "microseconds")
"""Remembered track width [m], path ahead of the front axle [m], clearance of the path [m], time of the step."""

TRAJECTORY_FIELDS = ("x", "y", "z", "yaw", "curvature", "velocity")
COLORS = {"left": (0.12, 0.47, 0.71, 1.0), "right": (0.91, 0.44, 0.04, 1.0)}
SEEN_SIZE = 0.06
OK, WARN, ERROR = 0, 1, 2
LEVELS = {"ok": OK, "holding": WARN, "blocked": WARN}


def make(kind: str, *values: Any) -> Any:
    """A message by its type and its fields in order."""
    return typestore().types[kind](*values)


def _header(frame: str) -> Any:
    return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", SECONDS, NANOSECONDS), frame)


def stamped(time: int, frame: str) -> Any:
    """A header at `time` [ns]."""
    return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", *divmod(time, 1_000_000_000)), frame)


def _point(x: float, y: float) -> Any:
    return make("geometry_msgs/msg/Point", x, y, 0.0)


def _vector(x: float, y: float, z: float = 0.0) -> Any:
    return make("geometry_msgs/msg/Vector3", x, y, z)


def _turn(z: float, w: float) -> Any:
    return make("geometry_msgs/msg/Quaternion", 0.0, 0.0, z, w)


def planar(pose: Floats) -> Floats:
    """(4,) x, y and the quaternion's z, w of x, y, yaw; or (N, 4) of (N, 3)."""
    flat = np.empty((*pose.shape[:-1], 4))
    half = 0.5 * pose[..., 2]
    flat[..., :2], flat[..., 2], flat[..., 3] = pose[..., :2], np.sin(half), np.cos(half)
    return flat


def scan(time: int, ranges: npt.NDArray[np.float32], header: Floats, scan_time: float) -> bytes:
    """sensor_msgs/LaserScan; header values in single precision.

    time: [ns] of the last beam; the message has that of the first, as defined. scan_time: [s] between scans.
    """
    angle_min, angle_increment, time_increment, range_min, range_max = header.tolist()
    message = make(
        LASER_SCAN,
        stamped(time - sweep(time_increment, len(ranges), scan_time), LASER),
        angle_min,
        angle_min + angle_increment * (len(ranges) - 1),
        angle_increment,
        time_increment,
        scan_time,
        range_min,
        range_max,
        ranges,
        np.zeros(0, dtype=np.float32),
    )
    return bytes(typestore().serialize_cdr(message, LASER_SCAN))


@lru_cache(maxsize=4)
def _odometry(frame: str) -> Template:
    pose = make("geometry_msgs/msg/Pose", _point(mark(0), mark(1)), _turn(mark(2), mark(3)))
    twist = make("geometry_msgs/msg/Twist", _vector(mark(4), 0.0), _vector(0.0, 0.0, mark(5)))
    unknown = np.zeros(36)
    message = make(
        ODOMETRY,
        _header(frame),
        BASE,
        make("geometry_msgs/msg/PoseWithCovariance", pose, unknown),
        make("geometry_msgs/msg/TwistWithCovariance", twist, unknown),
    )
    return Template(ODOMETRY, message, 6)


def odometry(time: int, frame: str, pose: Floats, speed: float, yaw_rate: float) -> bytes:
    """nav_msgs/Odometry of base_link in `frame`."""
    return _odometry(frame).fill(time, np.append(planar(pose), (speed, yaw_rate)))


@lru_cache(maxsize=1)
def _joint_state() -> Template:
    none = np.zeros(0)
    return Template(JOINT_STATE, make(JOINT_STATE, _header(""), ["steering"], np.array([mark(0)]), none, none), 1)


def joint_state(time: int, steering_angle: float) -> bytes:
    """sensor_msgs/JointState with the measured steering angle."""
    return _joint_state().fill(time, np.array([steering_angle]))


def drive(time: int, speed: float, steering_angle: float) -> bytes:
    """ackermann_msgs/AckermannDriveStamped."""
    message = make(DRIVE, stamped(time, BASE), make(ACKERMANN, steering_angle, 0.0, speed, 0.0, 0.0))
    return bytes(typestore().serialize_cdr(message, DRIVE))


@lru_cache(maxsize=4)
def _transforms(pairs: tuple[tuple[str, str], ...]) -> Template:
    transforms = [
        make(
            "geometry_msgs/msg/TransformStamped",
            _header(parent),
            child,
            make(
                "geometry_msgs/msg/Transform",
                _vector(mark(4 * i), mark(4 * i + 1)),
                _turn(mark(4 * i + 2), mark(4 * i + 3)),
            ),
        )
        for i, (parent, child) in enumerate(pairs)
    ]
    return Template(TF, make(TF, transforms), 4 * len(pairs))


def transforms(time: int, poses: dict[tuple[str, str], Floats]) -> bytes:
    """tf2_msgs/TFMessage of {(parent, child): x, y, yaw}."""
    return _transforms(tuple(poses)).fill(time, np.concatenate([planar(pose) for pose in poses.values()]))


@lru_cache(maxsize=4096)
def _wall(side: str, count: int) -> Template:
    marker: Any = typestore().types[MARKER]
    size = SEEN_SIZE
    message = make(
        MARKER,
        _header(BASE),
        side,
        0,
        marker.SPHERE_LIST,
        marker.ADD,
        make("geometry_msgs/msg/Pose", _point(0.0, 0.0), _turn(0.0, 1.0)),
        _vector(size, size, size),
        make("std_msgs/msg/ColorRGBA", *COLORS[side]),
        make("builtin_interfaces/msg/Duration", 0, 0),
        False,
        [_point(mark(2 * i), mark(2 * i + 1)) for i in range(count)],
        [],
        "",
        make("sensor_msgs/msg/CompressedImage", stamped(0, ""), "", np.zeros(0, dtype=np.uint8)),
        [],
        "",
        "",
        make("visualization_msgs/msg/MeshFile", "", np.zeros(0, dtype=np.uint8)),
        False,
    )
    return Template(MARKER, message, 2 * count)


def wall(time: int, side: str, rows: Floats) -> bytes:
    """visualization_msgs/Marker with the samples of one side: rows x, y, ..."""
    return _wall(side, len(rows)).fill(time, rows[:, :2].reshape(-1))


@lru_cache(maxsize=1024)
def _path(count: int) -> Template:
    poses = [
        make(
            "geometry_msgs/msg/PoseStamped",
            _header(BASE),
            make(
                "geometry_msgs/msg/Pose",
                _point(mark(4 * i), mark(4 * i + 1)),
                _turn(mark(4 * i + 2), mark(4 * i + 3)),
            ),
        )
        for i in range(count)
    ]
    return Template(PATH, make(PATH, _header(BASE), poses), 4 * count)


def path(time: int, poses: Floats) -> bytes:
    """nav_msgs/Path of rows x, y, yaw in base_link."""
    return _path(len(poses)).fill(time, planar(poses).reshape(-1))


def centerline(time: int, rows: Floats) -> bytes:
    """nav_msgs/Path of rows x, y, ...; headings along the line."""
    if len(rows) < 2:
        return path(time, np.column_stack([rows[:, :2], np.zeros(len(rows))]))
    steps = np.diff(rows[:, :2], axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    return path(time, np.column_stack([rows[:, :2], np.append(yaws, yaws[-1])]))


@lru_cache(maxsize=1)
def _cloud_fields() -> list[Any]:
    kind = "sensor_msgs/msg/PointField"
    field: Any = typestore().types[kind]
    return [make(kind, name, 4 * i, field.FLOAT32, 1) for i, name in enumerate(TRAJECTORY_FIELDS)]


def trajectory(time: int, rows: Floats) -> bytes:
    """sensor_msgs/PointCloud2 with TRAJECTORY_FIELDS, of path rows s, x, y, yaw, curvature, velocity."""
    values = np.zeros((len(rows), len(TRAJECTORY_FIELDS)), dtype="<f4")
    values[:, (0, 1, 3, 4, 5)] = rows[:, 1:]
    step = 4 * len(TRAJECTORY_FIELDS)
    data = values.reshape(-1).view(np.uint8)
    message = make(
        CLOUD, stamped(time, BASE), 1, len(rows), _cloud_fields(), False, step, step * len(rows), data, True
    )  # fmt: skip
    return bytes(typestore().serialize_cdr(message, CLOUD))


@lru_cache(maxsize=1)
def _lookahead() -> Template:
    return Template(POINT, make(POINT, _header(BASE), _point(mark(0), mark(1))), 2)


def lookahead(time: int, point: Floats) -> bytes:
    """geometry_msgs/PointStamped."""
    return _lookahead().fill(time, point)


@lru_cache(maxsize=len(STATUSES))
def _status(code: int) -> Template:
    name = STATUSES[code]
    one = make("diagnostic_msgs/msg/DiagnosticStatus", LEVELS.get(name, ERROR), "firstlap", name, "firstlap", [])
    return Template(DIAGNOSTICS, make(DIAGNOSTICS, _header(BASE), [one]), 0)


def status(time: int, code: int) -> bytes:
    """diagnostic_msgs/DiagnosticArray with the step's status."""
    return _status(code).fill(time, np.zeros(0))


@lru_cache(maxsize=1)
def _numbers() -> Template:
    labels = [make("std_msgs/msg/MultiArrayDimension", name, 1, 1) for name in NUMBERS]
    data = np.array([mark(i) for i in range(len(NUMBERS))])
    return Template(ARRAY, make(ARRAY, make("std_msgs/msg/MultiArrayLayout", labels, 0), data), len(NUMBERS))


def numbers(values: Floats) -> bytes:
    """std_msgs/Float64MultiArray of NUMBERS, whose names are the labels of its layout."""
    return _numbers().fill(0, values)
