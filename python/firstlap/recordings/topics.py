"""Assigns topics to roles: by type, by usual names, or as set by the user."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from firstlap.common.errors import InputError
from firstlap.perception.scan import Mount
from firstlap.recordings.messages import Topic

NONE = "none"
TF, TF_STATIC = "/tf", "/tf_static"


class Role(NamedTuple):
    """A role of a topic. usual: of several topics of the role's types, the first of these names is chosen."""

    option: str
    types: tuple[str, ...]
    usual: tuple[str, ...]
    needed: bool = False


SCAN = Role("--scan-topic", ("sensor_msgs/msg/LaserScan",), ("/scan",), needed=True)
ODOM = Role(
    "--odom-topic",
    ("nav_msgs/msg/Odometry",),
    (
        "/odom",
        "/car_state/odom",
        "/early_fusion/odom",
        "/state_estimation/odom",
        "/vesc/odom",
        "/odometry/filtered",
        "/ego_racecar/odom",
    ),
)
IMU = Role(
    "--imu-topic",
    ("sensor_msgs/msg/Imu",),
    ("/imu", "/imu/data", "/imu/data_raw", "/sensors/imu/raw", "/vesc/sensors/imu/raw"),
)
DRIVE = Role(
    "--drive-topic",
    ("ackermann_msgs/msg/AckermannDriveStamped", "ackermann_msgs/msg/AckermannDrive"),
    (
        # Commands to the motor, after the multiplexer of autonomy and joystick.
        "/ackermann_cmd",
        "/ackermann_drive",
        "/vesc/low_level/ackermann_cmd_mux/output",
        "/vesc/low_level/ackermann_cmd",
        "/vesc/ackermann_cmd",
        # Commands of the autonomy.
        "/drive",
        "/vesc/high_level/ackermann_cmd_mux/output",
        "/vesc/high_level/ackermann_cmd",
        "/vesc/high_level/ackermann_cmd_mux/input/nav_1",
        "/vesc/low_level/ackermann_cmd_mux/input/navigation",
        # Commands of a human driver.
        "/teleop",
        "/vesc/low_level/ackermann_cmd_mux/input/teleop",
    ),
)
POSE = Role(
    "--pose-topic",
    ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped"),
    ("/car_state/pose", "/tracked_pose", "/pf/viz/inferred_pose", "/amcl_pose"),
)
STEERING = ("sensor_msgs/msg/JointState",)
NOT_THE_CAR = (
    "/initialpose",
    "/goal_pose",
    "/move_base_simple/goal",
    "/car_state/odom_frenet",
    "/car_state/frenet/odom",
    "/car_state/frenet/pose",
)
"""Topics of a role's type that are never chosen automatically: goals, initial poses, waypoints."""


@dataclass(frozen=True)
class Topics:
    """The user's settings for a recording. Topic names: None is chosen automatically, "none" is not used.

    laser: the LiDAR's mounting, overrides the recording. speed: [m/s], used if the recording has none.
    """

    scan: str | None = None
    odom: str | None = None
    imu: str | None = None
    drive: str | None = None
    pose: str | None = None
    speed: float | None = None
    laser: Mount | None = None


@dataclass(frozen=True)
class Roles:
    """The topic of each role; None if there is none. remarks: one line per choice among several topics."""

    scan: Topic
    odom: Topic | None
    imu: Topic | None
    drive: Topic | None
    pose: Topic | None
    steering: Topic | None
    remarks: tuple[str, ...] = ()

    def names(self) -> dict[str, str]:
        """{role: topic} of the roles that have one."""
        return {role: topic.name for role, topic in vars(self).items() if isinstance(topic, Topic)}


def choose(topics: Mapping[str, Topic], wanted: Topics, ours: bool, where: str) -> Roles:
    """Chooses each role's topic among those that have messages.

    ours: one of our own logs, whose topic names are known. Raises InputError with all open choices if the user must
    choose.
    """
    truth = topics.get("/ground_truth/odom") if ours else None
    if ours:
        wanted = _ours(wanted, topics)
    chooser = _Chooser(topics, where)
    found = {
        "scan": chooser.find(SCAN, wanted.scan),
        "odom": chooser.find(ODOM, wanted.odom),
        "imu": chooser.find(IMU, wanted.imu),
        "drive": chooser.find(DRIVE, wanted.drive),
        "pose": chooser.find(POSE, wanted.pose) if wanted.pose or truth is None else truth,
    }
    if chooser.open:
        raise InputError(f"{where}: has {'; '.join(chooser.open)}")
    scan = found.pop("scan")
    if scan is None:
        held = ", ".join(sorted({topic.type for topic in topics.values()})) or "no messages"
        raise InputError(f"{where}: contains no LaserScan, only {held[:300]}")
    steering = topics.get("/joint_states") if ours else None
    return Roles(scan, **found, steering=steering, remarks=tuple(chooser.remarks))


def _ours(wanted: Topics, topics: Mapping[str, Topic]) -> Topics:
    known = {"scan": "/scan", "odom": "/odom", "drive": "/drive"}
    chosen: dict[str, Any] = {
        role: name for role, name in known.items() if name in topics and getattr(wanted, role) is None
    }
    return replace(wanted, **chosen)


class _Chooser:
    """Chooses the topics of roles. remarks: choices made among several. open: choices that the user must make."""

    def __init__(self, topics: Mapping[str, Topic], where: str) -> None:
        self._topics, self._where = topics, where
        self.remarks: list[str] = []
        self.open: list[str] = []

    def find(self, role: Role, wanted: str | None) -> Topic | None:
        """The role's topic. Raises InputError if `wanted` is not a topic of its type."""
        if wanted == NONE and not role.needed:
            return None
        of_type = sorted(name for name, topic in self._topics.items() if topic.type in role.types)
        if wanted is not None:
            return self._named(role, wanted, of_type)
        candidates = [name for name in of_type if name not in NOT_THE_CAR]
        if len(candidates) < 2:
            return self._topics[candidates[0]] if candidates else None
        return self._usual(role, candidates)

    def _named(self, role: Role, wanted: str, candidates: list[str]) -> Topic:
        for name in (wanted, f"/{wanted}"):
            if name in candidates:
                return self._topics[name]
        listed = ", ".join(candidates) or "none"
        raise InputError(
            f"{self._where}: {role.option} {wanted[:80]}: not a {_short(role)} topic with messages; expected {listed}"
        )

    def _usual(self, role: Role, candidates: list[str]) -> Topic | None:
        chosen = next((name for name in role.usual if name in candidates), None)
        if chosen is None:
            unless = "" if role.needed else f", or {role.option} {NONE}"
            self.open.append(
                f"{len(candidates)} {_short(role)} topics: {', '.join(candidates)}; "
                f"choose one with {role.option}{unless}"
            )
            return None
        others = ", ".join(name for name in candidates if name != chosen)
        self.remarks.append(
            f"of {len(candidates)} {_short(role)} topics, {chosen} is used, not {others}: see {role.option}"
        )
        return self._topics[chosen]


def _short(role: Role) -> str:
    return role.types[0].rpartition("/")[2]
