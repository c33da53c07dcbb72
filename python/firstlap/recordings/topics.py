"""Which topic is what: found by type, or named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from firstlap.errors import InputError
from firstlap.recordings.messages import Topic

SCAN = ("sensor_msgs/msg/LaserScan",)
ODOM = ("nav_msgs/msg/Odometry",)
IMU = ("sensor_msgs/msg/Imu",)
DRIVE = ("ackermann_msgs/msg/AckermannDriveStamped", "ackermann_msgs/msg/AckermannDrive")
POSE = ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
STEERING = ("sensor_msgs/msg/JointState",)
NONE = "none"


@dataclass(frozen=True)
class Topics:
    """What a person says of a recording. Names of topics: None is to be found, "none" is not to be used."""

    scan: str | None = None
    odom: str | None = None
    imu: str | None = None
    drive: str | None = None
    pose: str | None = None
    speed: float | None = None
    """[m/s] where the recording tells none."""


@dataclass(frozen=True)
class Roles:
    """The topic of each role; None where there is none."""

    scan: Topic
    odom: Topic | None
    imu: Topic | None
    drive: Topic | None
    pose: Topic | None
    steering: Topic | None

    def names(self) -> dict[str, str]:
        """{role: topic}, those that are there."""
        return {role: topic.name for role, topic in vars(self).items() if topic is not None}


def choose(topics: Mapping[str, Topic], wanted: Topics, ours: bool, where: str) -> Roles:
    """Finds each role's topic among those that hold messages. Raises InputError where it takes a person to choose.

    ours: a log of our own writing, whose names are known.
    """
    truth = topics.get("/ground_truth/odom") if ours else None
    if ours:
        wanted = _ours(wanted, topics)
    scan = _one(topics, SCAN, wanted.scan, "--scan-topic", where)
    if scan is None:
        held = ", ".join(sorted({topic.type for topic in topics.values()})) or "no message at all"
        raise InputError(f"{where}: no LaserScan inside; it holds {held[:300]}")
    return Roles(
        scan=scan,
        odom=_one(topics, ODOM, wanted.odom, "--odom-topic", where),
        imu=_one(topics, IMU, wanted.imu, "--imu-topic", where),
        drive=_one(topics, DRIVE, wanted.drive, "--drive-topic", where),
        pose=_one(topics, POSE, wanted.pose, "--pose-topic", where) if wanted.pose or truth is None else truth,
        steering=topics.get("/joint_states") if ours else None,
    )


def _ours(wanted: Topics, topics: Mapping[str, Topic]) -> Topics:
    known = {"scan": "/scan", "odom": "/odom", "drive": "/drive"}
    chosen: dict[str, Any] = {
        role: name for role, name in known.items() if name in topics and getattr(wanted, role) is None
    }
    return replace(wanted, **chosen)


def _one(
    topics: Mapping[str, Topic], types: tuple[str, ...], wanted: str | None, option: str, where: str
) -> Topic | None:
    if wanted == NONE and option != "--scan-topic":
        return None
    candidates = sorted(name for name, topic in topics.items() if topic.type in types)
    if wanted is not None:
        for name in (wanted, f"/{wanted}"):
            if name in candidates:
                return topics[name]
        listed = ", ".join(candidates) or "none"
        raise InputError(
            f"{where}: {option} {wanted[:80]}: not a {_short(types)} topic with messages; those are {listed}"
        )
    if len(candidates) > 1:
        unless = "" if option == "--scan-topic" else f", or {option} {NONE}"
        raise InputError(
            f"{where}: has {len(candidates)} {_short(types)} topics: {', '.join(candidates)}; "
            f"choose one with {option}{unless}"
        )
    return topics[candidates[0]] if candidates else None


def _short(types: tuple[str, ...]) -> str:
    return types[0].rpartition("/")[2]
