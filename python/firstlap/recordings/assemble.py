"""Makes a recording from raw messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.common.imu import measures
from firstlap.recordings import topics as types
from firstlap.recordings.about import RECORD, About
from firstlap.recordings.clock import Timeline, periods, sweeps, timeline
from firstlap.recordings.laser import OPTION, UNKNOWN, Mounting, mounting_by_frames, turned
from firstlap.recordings.log_messages import BASE
from firstlap.recordings.messages import TRANSFORMS, Stored, Topic, decode
from firstlap.recordings.paths import name_of
from firstlap.recordings.recording import Recording
from firstlap.recordings.scans import BLIND, Scans, collect, nanoseconds
from firstlap.recordings.state import Series, Sources, commands_at, in_radians, series, states_at
from firstlap.recordings.topics import Roles, Topics, choose

ROLES = (types.SCAN, types.ODOM, types.IMU, types.DRIVE, types.POSE)
WANTED = frozenset((*(kind for role in ROLES for kind in role.types), *types.STEERING, *TRANSFORMS))
MESSAGES_PER_CALLBACK = 500

Floats = npt.NDArray[np.float64]
Raw = dict[str, list[tuple[int, bytes]]]


def assemble(
    stored: Stored, path: Path, wanted: Topics, on_progress: Callable[[int], object] | None = None
) -> Recording:
    """Reads and decodes all relevant messages and puts them on one clock. Raises InputError if no scan can be read."""
    raw = _read(stored, on_progress)
    held = {name: stored.topics[name] for name in raw}
    others = {name: topic for name, topic in stored.topics.items() if topic.type not in WANTED}
    try:
        roles = choose(held or others, wanted, RECORD in stored.metadata, str(path))
    except InputError as error:
        damage = "; ".join(stored.remarks)
        raise InputError(f"{error}{f' ({damage})' if damage else ''}") from None
    return _Assembly(stored, path, roles, raw, wanted).recording()


def _read(stored: Stored, on_progress: Callable[[int], object] | None) -> Raw:
    raw: Raw = {}
    stored.wanted = WANTED
    for count, message in enumerate(stored.messages()):
        if stored.topics[message.topic].type in WANTED:
            raw.setdefault(message.topic, []).append((message.time, message.data))
        if on_progress and count % MESSAGES_PER_CALLBACK == 0:
            on_progress(count)
    return raw


class _Assembly:
    """The steps from raw messages to a recording, and their remarks."""

    def __init__(self, stored: Stored, path: Path, roles: Roles, raw: Raw, wanted: Topics) -> None:
        self.stored, self.path, self.roles, self.raw, self.wanted = stored, path, roles, raw, wanted
        self.remarks = [*stored.remarks, *roles.remarks]
        self.known: dict[str, list[tuple[int, Any]]] = {}

    def recording(self) -> Recording:
        about = self.about()
        mounting = self.mounting(about)
        scans = collect(self.decoded(self.roles.scan), mounting.mount)
        self.remarks += [*mounting.remarks, *scans.remarks]
        if not scans.usable:
            why = scans.reason or "; ".join(self.remarks)
            why += f"; {OPTION} says how it is mounted" if scans.fault == BLIND else ""
            raise InputError(f"{self.path}: no valid scan in {self.roles.scan.name}: {why}")
        self.check_counts()
        line = timeline(_ended(scans, about), scans.logged)
        self.remarks += line.remarks
        origin = int(line.times[0])
        times = (line.times - origin) / 1e9
        held = self.sources(line, origin)
        found = states_at(times, held, self.wanted.speed)
        self.remarks += found.remarks
        poses = None if held.poses is None else held.poses.at(times)
        whole = len(times) if about is None else _whole_scans(times, held.commands)
        if not whole:
            raise InputError(f"{self.path}: is cut off before the first scan's command")
        if whole < len(times):
            self.remarks.append("the last scan's command and measurements are missing: the scan was dropped")
        recording = Recording(
            name=name_of(self.path),
            source=str(self.path),
            ranges=scans.ranges,
            headers=turned(_exact(scans.headers, about), mounting.mount),
            start=origin / 1e9,
            stamps=times,
            dts=periods(line.times, *((about.scan_period, about.first_dt) if about else ())),
            states=found.states,
            sources={**found.sources, "laser": mounting.source},
            commands=commands_at(times, held.commands),
            poses=poses,
            frame=self.frame if poses is not None else "",
            laser=mounting.mount,
            lateral_speed=None if held.lateral is None else held.lateral.at(times)[:, 0],
            gyro=None if held.turning is None else held.turning.near_values(times)[:, 0],
            acceleration=None if held.acceleration is None else held.acceleration.near_values(times),
            remarks=tuple(self.remarks),
            topics=self.roles.names(),
            about=about,
        )
        return recording.first(whole)

    def decoded(self, topic: Topic | None) -> list[tuple[int, Any]]:
        """(log time, message), in log order; messages that cannot be decoded are counted."""
        if topic is None:
            return []
        if topic.name not in self.known:
            self.known[topic.name] = self._decoded(topic)
        return self.known[topic.name]

    def _decoded(self, topic: Topic) -> list[tuple[int, Any]]:
        in_order = sorted(self.raw[topic.name], key=lambda pair: pair[0])
        decoded = [(time, decode(topic, data)) for time, data in in_order]
        messages = [(time, message) for time, message in decoded if message is not None]
        lost = len(decoded) - len(messages)
        if lost:
            self.remarks.append(f"{lost} of {len(self.raw[topic.name])} messages of {topic.name} cannot be decoded")
        return messages

    def check_counts(self) -> None:
        name = self.roles.scan.name
        there, claimed = len(self.raw[name]), self.stored.claimed.get(name)
        if claimed is not None and claimed != there:
            self.remarks.append(f"{name}: {there} of {claimed} messages in the metadata can be read")

    def about(self) -> About | None:
        if RECORD not in self.stored.metadata:
            return None
        try:
            return About.from_metadata(self.stored.metadata[RECORD], str(self.path))
        except InputError as error:
            self.remarks.append(str(error))
            return None

    def mounting(self, about: About | None) -> Mounting:
        """The LiDAR's mounting; for our own logs, that of their car. Raises InputError."""
        if self.wanted.laser is not None:
            return Mounting(self.wanted.laser, OPTION)
        if about is not None:
            return UNKNOWN
        children = [message.child_frame_id.lstrip("/") for _, message in self.decoded(self.roles.odom)[:1]]
        frames = [message.header.frame_id.lstrip("/") for _, message in self.decoded(self.roles.scan)[:1]]
        static, moving = self.transforms(types.TF_STATIC), self.transforms(types.TF)
        return mounting_by_frames(
            static, moving, [BASE, *filter(None, children)], frames[0] if frames else "", str(self.path)
        )

    def transforms(self, name: str) -> Iterator[Any]:
        """The messages of the topics of that name, in any namespace."""
        for topic in self.stored.topics.values():
            if topic.type in TRANSFORMS and topic.name.endswith(name):
                for _, data in self.raw.get(topic.name, ()):
                    message = decode(topic, data)
                    if message is not None:
                        yield message

    def sources(self, line: Timeline, origin: int) -> Sources:
        """Every other topic, on the scans' clock."""

        def over_time(topic: Topic | None, values: Callable[[Any], tuple[float, ...]]) -> Series | None:
            messages = self.decoded(topic)
            if topic is None or not messages:
                return None
            times = self.times_of(messages, line, topic.name)
            return series(topic.name, (times - origin) / 1e9, np.array([values(message) for _, message in messages]))

        roles = self.roles
        self.frame = ""
        poses = over_time(roles.pose or roles.odom, self.pose_of)
        if poses is not None:
            poses.values[:, 2] = np.unwrap(poses.values[:, 2])
        moved = poses is not None and bool(np.ptp(poses.values, axis=0).max() > 0.0)
        commands = in_radians(over_time(roles.drive, _command_of), 1, self.remarks)
        moving = over_time(roles.odom, _twist_of)
        return Sources(
            twist=None if moving is None else Series(moving.name, moving.times, moving.values[:, :2]),
            lateral=None if moving is None else Series(moving.name, moving.times, moving.values[:, 2:]),
            turning=over_time(roles.imu, _turning_of),
            acceleration=over_time(roles.imu, _acceleration_of),
            commands=commands,
            steering=over_time(roles.steering, lambda m: (m.position[0],)),
            poses=poses if moved else None,
            imu_first=self.wanted.imu is not None,
        )

    def pose_of(self, message: Any) -> tuple[float, float, float]:
        self.frame = self.frame or str(message.header.frame_id).lstrip("/")
        pose = message.pose if hasattr(message.pose, "position") else message.pose.pose
        q = pose.orientation
        yaw = np.arctan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        return pose.position.x, pose.position.y, float(yaw)

    def times_of(self, messages: list[tuple[int, Any]], line: Timeline, topic: str) -> npt.NDArray[np.int64]:
        """(M,) [ns] on the scans' clock: header stamps if the scans use theirs and both are from the same clock, else
        log times."""
        logged = np.array([time for time, _ in messages], dtype=np.int64)
        if line.by == "log" or not hasattr(messages[0][1], "header"):
            return line.of_logging(logged)
        stamped = np.array([nanoseconds(message.header.stamp) for _, message in messages], dtype=np.int64)
        if np.any(np.diff(stamped) < 0) or len(np.unique(stamped)) * 2 <= len(stamped):
            return line.of_logging(logged)
        apart = line.apart(stamped, logged)
        if apart:
            scan = self.roles.scan.name
            self.remarks.append(f"the clocks of {scan} and {topic} are {abs(apart):.1f} s apart: {topic} is matched to "
                                "the scans by log time")  # fmt: skip
            return line.of_logging(logged)
        return stamped


def _ended(scans: Scans, about: About | None) -> npt.NDArray[np.int64]:
    """(N,) [ns] of the last beams by the scans' stamps; these are the log times of our own logs."""
    if about is not None:
        return scans.logged
    beams = [len(one) for one in scans.ranges]
    return np.asarray(scans.stamped + sweeps(scans.headers[:, 2], beams, scans.stamped))


def _whole_scans(times: Floats, commands: Series | None) -> int:
    """The number of a log's scans that are complete: the command is written last, at their stamp."""
    if commands is None:
        return len(times)
    return int(np.searchsorted(times, commands.times[-1] + 0.5e-9, side="right"))


def _exact(headers: Floats, about: About | None) -> Floats:
    """The headers with all digits, if the log's metadata has them."""
    if about is None or about.header is None or len(about.header) != headers.shape[1]:
        return headers
    header = np.array(about.header)
    same = np.all(headers == header.astype(np.float32), axis=1)
    return np.where(same[:, None], header, headers)


def _twist_of(message: Any) -> tuple[float, float, float]:
    """Speed, yaw rate and lateral speed; no planner needs the lateral speed, so an invalid one becomes 0."""
    twist = message.twist.twist
    left = twist.linear.y
    return twist.linear.x, twist.angular.z, left if math.isfinite(left) else 0.0


def _acceleration_of(message: Any) -> tuple[float, float]:
    """Acceleration [m/s^2], forward and left; NaN if the IMU measures none."""
    if not measures(message.linear_acceleration_covariance):
        return math.nan, math.nan
    return message.linear_acceleration.x, message.linear_acceleration.y


def _turning_of(message: Any) -> tuple[float]:
    """Yaw rate [rad/s]; NaN if the IMU measures none."""
    return (message.angular_velocity.z if measures(message.angular_velocity_covariance) else math.nan,)


def _command_of(message: Any) -> tuple[float, float]:
    drive = message.drive if hasattr(message, "drive") else message
    return drive.speed, drive.steering_angle
