"""Builds the messages of the simulator node."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan

from firstlap.common.imu import NOT_MEASURED
from firstlap.perception.scan import Mount
from firstlap.ros.conversions import float_array, quaternion_of, set_stamp, yaw_of
from firstlap.tracks.track import Track

CELL = 0.05
"""[m] Cell size of the published map."""
BORDER = 1.0
GRAVITY = 9.81


def scan(
    stamp: float,
    frame: str,
    ranges: npt.NDArray[np.float32],
    header: tuple[float, ...],
    period: float,
    end_stamp: bool = False,
) -> LaserScan:
    """stamp: time [s] of the last beam; the message has that of the first one, as sensor_msgs/LaserScan defines, unless
    `end_stamp`."""
    angle_min, angle_increment, time_increment, range_min, range_max = header
    message = LaserScan()
    set_stamp(message.header.stamp, stamp - (0.0 if end_stamp else time_increment * (len(ranges) - 1)))
    message.header.frame_id = frame
    message.angle_min, message.angle_increment = angle_min, angle_increment
    message.angle_max = angle_min + angle_increment * (len(ranges) - 1)
    message.time_increment, message.scan_time = time_increment, period
    message.range_min, message.range_max = range_min, range_max
    message.ranges = float_array(ranges)
    return message


def odometry(stamp: float, frame: str, child: str, pose: Any, motion: tuple[float, float, float]) -> Odometry:
    """pose: x, y [m], yaw [rad]; motion: forward, lateral [m/s], yaw rate [rad/s]."""
    message = Odometry()
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id, message.child_frame_id = frame, child
    message.pose.pose.position.x, message.pose.pose.position.y = float(pose[0]), float(pose[1])
    turn = message.pose.pose.orientation
    turn.z, turn.w = quaternion_of(float(pose[2]))
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.angular.z = motion
    return message


def imu(stamp: float, frame: str, yaw_rate: float, acceleration: tuple[float, float]) -> Imu:
    """Measured yaw rate [rad/s] and acceleration [m/s^2], forward and left; no orientation."""
    message = Imu()
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = frame
    message.orientation_covariance[0] = NOT_MEASURED
    message.angular_velocity.z = yaw_rate
    message.linear_acceleration.x, message.linear_acceleration.y = acceleration
    message.linear_acceleration.z = GRAVITY
    return message


def joints(stamp: float, steering_angle: float) -> JointState:
    """The measured steering angle [rad]."""
    message = JointState(name=["steering"], position=[steering_angle])
    set_stamp(message.header.stamp, stamp)
    return message


def clock(time: float) -> Clock:
    """/clock"""
    message = Clock()
    set_stamp(message.clock, time)
    return message


def transform(stamp: float, parent: str, child: str, pose: Any) -> TransformStamped:
    """pose: x, y [m], yaw [rad] of `child` in `parent`."""
    message = TransformStamped()
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id, message.child_frame_id = parent, child
    place = message.transform
    place.translation.x, place.translation.y = float(pose[0]), float(pose[1])
    place.rotation.z, place.rotation.w = quaternion_of(float(pose[2]))
    return message


def laser_place(parent: str, child: str, mount: Mount) -> TransformStamped:
    """The LiDAR mounting for /tf_static. Upside down is a roll of 180 degrees."""
    message = transform(0.0, parent, child, (mount.x, mount.y, mount.yaw))
    if mount.upside_down:
        turn = message.transform.rotation
        turn.x, turn.y, turn.z, turn.w = turn.w, turn.z, 0.0, 0.0
    return message


def pose_of(pose: Any) -> tuple[float, float, float]:
    """x, y, yaw of a geometry_msgs/Pose."""
    return pose.position.x, pose.position.y, yaw_of(pose.orientation)


def occupancy(track: Track) -> OccupancyGrid:
    """The walls as a map, for rviz and for map-based stacks."""
    segments = np.asarray(track.to_arrays()["segments"])
    corner = segments.reshape(-1, 2).min(axis=0) - BORDER
    size = np.ceil((segments.reshape(-1, 2).max(axis=0) + BORDER - corner) / CELL).astype(int)
    cells = np.zeros((size[1], size[0]), dtype=np.int8)
    for x1, y1, x2, y2 in segments:
        steps = int(np.hypot(x2 - x1, y2 - y1) / (0.5 * CELL)) + 2
        share = np.linspace(0.0, 1.0, steps)
        columns = ((x1 + share * (x2 - x1) - corner[0]) / CELL).astype(int)
        rows = ((y1 + share * (y2 - y1) - corner[1]) / CELL).astype(int)
        cells[rows, columns] = 100
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.resolution = CELL
    message.info.width, message.info.height = int(size[0]), int(size[1])
    message.info.origin.position.x, message.info.origin.position.y = float(corner[0]), float(corner[1])
    message.info.origin.orientation.w = 1.0
    message.data = cells.reshape(-1).tolist()
    return message
