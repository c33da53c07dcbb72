"""The messages of our own logs and of the driving node: one function per topic that serializes a standard ROS message.

frame: frame_id of the results, base_link by default. time: stamp [ns].
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache, partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap.recordings.cdr import LENGTH, NANOSECONDS, SECONDS, Series, Template, mark, put_length, put_texts
from firstlap.recordings.clock import sweep
from firstlap.recordings.messages import ACKERMANN, typestore
from firstlap.recordings.step_log import PATH_COLUMNS, STATUSES
from firstlap.recordings.trace_tables import FLAG, FLOAT, INT, SMALL, TRAJECTORY, Rows

Floats = npt.NDArray[np.float64]

MAP, ODOM, BASE, LASER = "map", "odom", "base_link", "laser"
HEADER = "std_msgs/msg/Header"
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
"""Track width [m], path length ahead of the front axle [m], clearance of the path [m], compute time of the step."""

COLORS = {"left": (0.12, 0.47, 0.71, 1.0), "right": (0.91, 0.44, 0.04, 1.0)}
SEEN_SIZE = 0.06
OK, WARN, ERROR = 0, 1, 2
HARDWARE = "firstlap"
LEVELS = {"ok": OK, "holding": WARN, "blocked": WARN}


def make(kind: str, *values: Any) -> Any:
    """A message by its type and its fields in order."""
    return typestore().types[kind](*values)


def _header(frame: str) -> Any:
    return make(HEADER, make("builtin_interfaces/msg/Time", SECONDS, NANOSECONDS), frame)


def stamped(time: int, frame: str) -> Any:
    """A header at `time` [ns]."""
    return make(HEADER, make("builtin_interfaces/msg/Time", *divmod(time, 1_000_000_000)), frame)


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


def _wall(side: str, frame: str, count: int) -> Any:
    """The message with marks in place of its numbers."""
    marker: Any = typestore().types[MARKER]
    size = SEEN_SIZE
    return make(
        MARKER,
        _header(frame),
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


@lru_cache(maxsize=8)
def _walls(side: str, frame: str) -> Series:
    return Series(MARKER, partial(_wall, side, frame), 2)


def wall(time: int, side: str, rows: Floats, frame: str = BASE) -> bytes:
    """visualization_msgs/Marker with the samples of one side: rows x, y, ..."""
    return _walls(side, frame).fill(time, rows[:, :2])


def _path(frame: str, count: int) -> Any:
    """The message with marks in place of its numbers."""
    poses = [
        make(
            "geometry_msgs/msg/PoseStamped",
            _header(frame),
            make(
                "geometry_msgs/msg/Pose",
                _point(mark(4 * i), mark(4 * i + 1)),
                _turn(mark(4 * i + 2), mark(4 * i + 3)),
            ),
        )
        for i in range(count)
    ]
    return make(PATH, _header(frame), poses)


@lru_cache(maxsize=4)
def _paths(frame: str) -> Series:
    return Series(PATH, partial(_path, frame), 4)


def path(time: int, poses: Floats, frame: str = BASE) -> bytes:
    """nav_msgs/Path of rows x, y, yaw."""
    return _paths(frame).fill(time, planar(poses))


def centerline(time: int, rows: Floats, frame: str = BASE) -> bytes:
    """nav_msgs/Path of rows x, y, ...; headings along the line."""
    if len(rows) < 2:
        return path(time, np.column_stack([rows[:, :2], np.zeros(len(rows))]), frame)
    steps = np.diff(rows[:, :2], axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    return path(time, np.column_stack([rows[:, :2], np.append(yaws, yaws[-1])]), frame)


POINT_TYPES = {SMALL: 1, FLAG: 2, INT: 5, FLOAT: 7}
"""Type of a column -> the constant of sensor_msgs/PointField."""


@lru_cache(maxsize=64)
def _empty_cloud(frame: str, kind: np.dtype[Any]) -> tuple[Template, int]:
    """A message without rows, and the offset of its number of rows."""
    field = "sensor_msgs/msg/PointField"
    fields = [
        make(field, name, offset, POINT_TYPES[column.str], 1)
        for name, (column, offset, *_) in (kind.fields or {}).items()
    ]
    header = bytearray(Template(HEADER, _header(frame), 0).fill(0))
    put_length(header, 1)  # the height
    put_length(header, 0)
    message = make(CLOUD, _header(frame), 1, 0, fields, False, kind.itemsize, 0, np.zeros(0, dtype=np.uint8), True)
    return Template(CLOUD, message, 0), len(header) - LENGTH.size


def cloud(time: int, rows: Rows, frame: str = BASE) -> bytes:
    """sensor_msgs/PointCloud2 of a table's rows, whose columns are its fields."""
    empty, width_at = _empty_cloud(frame, rows.dtype)
    message, data = bytearray(empty.fill(time)), rows.tobytes()
    LENGTH.pack_into(message, width_at, len(rows))
    size = LENGTH.pack(len(data))
    message[-2 * LENGTH.size - 1 : -1] = size + size + data  # one row's size, the data's, the data; then whether dense
    return bytes(message)


def trajectory(time: int, rows: Floats, frame: str = BASE) -> bytes:
    """sensor_msgs/PointCloud2 of the table TRAJECTORY, of path rows s, x, y, yaw, curvature, velocity."""
    columns = dict(zip(PATH_COLUMNS, rows.T, strict=True))
    return cloud(time, TRAJECTORY.rows({"path": columns}), frame)


@lru_cache(maxsize=4)
def _lookahead(frame: str) -> Template:
    return Template(POINT, make(POINT, _header(frame), _point(mark(0), mark(1))), 2)


def lookahead(time: int, point: Floats, frame: str = BASE) -> bytes:
    """geometry_msgs/PointStamped."""
    return _lookahead(frame).fill(time, point)


class Diagnosis(NamedTuple):
    """One diagnostic_msgs/DiagnosticStatus: name, message, level and values."""

    name: str
    message: str
    level: int = OK
    values: Mapping[str, str] = {}


@lru_cache(maxsize=4)
def _no_diagnostics(frame: str) -> Template:
    return Template(DIAGNOSTICS, make(DIAGNOSTICS, _header(frame), []), 0)


def diagnostics(time: int, about: list[Diagnosis], frame: str = BASE) -> bytes:
    """diagnostic_msgs/DiagnosticArray."""
    data = bytearray(_no_diagnostics(frame).fill(time))
    LENGTH.pack_into(data, len(data) - LENGTH.size, len(about))
    for one in about:
        data.append(one.level)
        put_texts(data, (one.name, one.message, HARDWARE))
        put_length(data, len(one.values))
        put_texts(data, chain.from_iterable(one.values.items()))
    return bytes(data)


def diagnosis(status: str, values: Mapping[str, str] | None = None) -> Diagnosis:
    """The diagnosis of a step with this status."""
    return Diagnosis(HARDWARE, status, LEVELS.get(status, ERROR), values or {})


def status(time: int, code: int, frame: str = BASE) -> bytes:
    """diagnostic_msgs/DiagnosticArray with the step's status."""
    return diagnostics(time, [diagnosis(STATUSES[code])], frame)


@lru_cache(maxsize=1)
def _numbers() -> Template:
    labels = [make("std_msgs/msg/MultiArrayDimension", name, 1, 1) for name in NUMBERS]
    data = np.array([mark(i) for i in range(len(NUMBERS))])
    return Template(ARRAY, make(ARRAY, make("std_msgs/msg/MultiArrayLayout", labels, 0), data), len(NUMBERS))


def numbers(values: Floats) -> bytes:
    """std_msgs/Float64MultiArray of NUMBERS, whose names are the labels of its layout."""
    return _numbers().fill(0, values)
