"""From raw messages to a recording."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.errors import InputError
from firstlap.recordings import topics as types
from firstlap.recordings.about import RECORD, About
from firstlap.recordings.clock import Timeline, periods, timeline
from firstlap.recordings.messages import Stored, Topic, decode
from firstlap.recordings.recording import Recording
from firstlap.recordings.scans import collect, nanoseconds
from firstlap.recordings.state import Series, Sources, commands_at, series, states_at
from firstlap.recordings.topics import Roles, Topics, choose

WANTED = frozenset(types.SCAN + types.ODOM + types.IMU + types.DRIVE + types.POSE + types.STEERING)
MESSAGES_PER_LOOK = 500

Floats = npt.NDArray[np.float64]
Raw = dict[str, list[tuple[int, bytes]]]


def assemble(stored: Stored, path: Path, wanted: Topics, look: Callable[[int], object] | None = None) -> Recording:
    """Reads everything of use, decodes it and puts it on one clock. Raises InputError where no scan can be read."""
    raw = _read(stored, look)
    held = {name: stored.topics[name] for name in raw}
    others = {name: topic for name, topic in stored.topics.items() if topic.type not in WANTED}
    try:
        roles = choose(held or others, wanted, RECORD in stored.metadata, str(path))
    except InputError as error:
        damage = "; ".join(stored.remarks)
        raise InputError(f"{error}{f' ({damage})' if damage else ''}") from None
    return _Assembly(stored, path, roles, raw, wanted).recording()


def _read(stored: Stored, look: Callable[[int], object] | None) -> Raw:
    raw: Raw = {}
    stored.wanted = WANTED
    for count, message in enumerate(stored.messages()):
        if stored.topics[message.topic].type in WANTED:
            raw.setdefault(message.topic, []).append((message.time, message.data))
        if look and count % MESSAGES_PER_LOOK == 0:
            look(count)
    return raw


class _Assembly:
    """The steps from raw messages to a recording, with the remarks that they leave."""

    def __init__(self, stored: Stored, path: Path, roles: Roles, raw: Raw, wanted: Topics) -> None:
        self.stored, self.path, self.roles, self.raw, self.wanted = stored, path, roles, raw, wanted
        self.remarks = list(stored.remarks)

    def recording(self) -> Recording:
        scans = collect(self.decoded(self.roles.scan))
        self.remarks += scans.remarks
        if not scans.ranges:
            raise InputError(f"{self.path}: no scan of {self.roles.scan.name} can be read ({'; '.join(self.remarks)})")
        self.check_counts()
        line = timeline(scans.stamped, scans.logged)
        self.remarks += line.remarks
        about = self.about()
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
            self.remarks.append("the last scan's command and measurements are cut off: it was left out")
        recording = Recording(
            name=self.path.name if self.path.is_dir() else self.path.stem,
            source=str(self.path),
            ranges=scans.ranges,
            headers=_exact(scans.headers, about),
            start=origin / 1e9,
            stamps=times,
            dts=periods(line.times, *((about.scan_period, about.first_dt) if about else ())),
            states=found.states,
            sources=found.sources,
            commands=commands_at(times, held.commands),
            poses=poses,
            frame=self.frame if poses is not None else "",
            laser_x=float(about.car.core.get("geometry", "laser_x")) if about else None,  # type: ignore[arg-type]
            remarks=tuple(self.remarks),
            topics=self.roles.names(),
            about=about,
        )
        return recording.first(whole)

    def decoded(self, topic: Topic | None) -> list[tuple[int, Any]]:
        """(time of logging, message), in the order of logging; what cannot be decoded is counted."""
        if topic is None:
            return []
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
            self.remarks.append(f"the metadata says {claimed} messages of {name}, {there} can be read")

    def about(self) -> About | None:
        if RECORD not in self.stored.metadata:
            return None
        try:
            return About.from_metadata(self.stored.metadata[RECORD], str(self.path))
        except InputError as error:
            self.remarks.append(str(error))
            return None

    def sources(self, line: Timeline, origin: int) -> Sources:
        """Every other topic, on the scans' clock."""

        def over_time(topic: Topic | None, values: Callable[[Any], tuple[float, ...]]) -> Series | None:
            messages = self.decoded(topic)
            if topic is None or not messages:
                return None
            times = self.times_of(messages, line.by)
            return series(topic.name, (times - origin) / 1e9, np.array([values(message) for _, message in messages]))

        roles = self.roles
        self.frame = ""
        poses = over_time(roles.pose or roles.odom, self.pose_of)
        if poses is not None:
            poses.values[:, 2] = np.unwrap(poses.values[:, 2])
        moved = poses is not None and bool(np.ptp(poses.values, axis=0).max() > 0.0)
        twist = over_time(roles.odom, lambda m: (m.twist.twist.linear.x, m.twist.twist.angular.z))
        return Sources(
            twist=twist,
            turning=over_time(roles.imu, lambda m: (m.angular_velocity.z,)),
            commands=over_time(roles.drive, _command_of),
            steering=over_time(roles.steering, lambda m: (m.position[0],)),
            poses=poses if moved else None,
            imu_first=self.wanted.imu is not None,
        )

    def pose_of(self, message: Any) -> tuple[float, float, float]:
        self.frame = self.frame or str(message.header.frame_id)
        pose = message.pose if hasattr(message.pose, "position") else message.pose.pose
        q = pose.orientation
        yaw = np.arctan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        return pose.position.x, pose.position.y, float(yaw)

    @staticmethod
    def times_of(messages: list[tuple[int, Any]], by: str) -> npt.NDArray[np.int64]:
        """(M,) [ns]: stamps where the scans go by theirs and these are filled in, else times of logging."""
        logged = np.array([time for time, _ in messages], dtype=np.int64)
        if by == "log" or not hasattr(messages[0][1], "header"):
            return logged
        stamped = np.array([nanoseconds(message.header.stamp) for _, message in messages], dtype=np.int64)
        return stamped if np.all(np.diff(stamped) >= 0) and len(np.unique(stamped)) * 2 > len(stamped) else logged


def _whole_scans(times: Floats, commands: Series | None) -> int:
    """How many of a log's scans were written with all that belongs to them: the command comes last, at their stamp."""
    if commands is None:
        return len(times)
    return int(np.searchsorted(times, commands.times[-1] + 0.5e-9, side="right"))


def _exact(headers: Floats, about: About | None) -> Floats:
    """The headers with all their digits, where the log tells them."""
    if about is None or about.header is None or len(about.header) != headers.shape[1]:
        return headers
    header = np.array(about.header)
    same = np.all(headers == header.astype(np.float32), axis=1)
    return np.where(same[:, None], header, headers)


def _command_of(message: Any) -> tuple[float, float]:
    drive = message.drive if hasattr(message, "drive") else message
    return drive.speed, drive.steering_angle
