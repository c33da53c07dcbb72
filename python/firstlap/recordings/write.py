"""Writes our own logs: MCAP files of standard ROS messages, written by a separate thread during the race."""

from __future__ import annotations

import os
import queue
import stat
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from mcap.writer import CompressionType, Writer

from firstlap.common.errors import InputError
from firstlap.common.file_lock import lock_open_file
from firstlap.common.files import LOGS, check_writable
from firstlap.perception.scan import laser_of
from firstlap.recordings import log_messages as ros
from firstlap.recordings.about import RECORD, About
from firstlap.recordings.messages import typestore
from firstlap.recordings.step_log import Columns, rows_of

Floats = npt.NDArray[np.float64]

WAITING = 8000
"""Maximum number of scans that wait to be written, about 150 MB; then the race waits, so that none is lost."""
FLUSH_EVERY = 0.5
"""[s] Maximum time between two flushes: this much is lost if the process is killed."""
ANYBODY = 0o666
"""Permissions of a new file, before the umask."""
TOPICS = {
    "/scan": ros.LASER_SCAN,
    "/odom": ros.ODOMETRY,
    "/joint_states": ros.JOINT_STATE,
    "/drive": ros.DRIVE,
    "/tf": ros.TF,
    "/tf_static": ros.TF,
    "/ground_truth/odom": ros.ODOMETRY,
    "/firstlap/walls": ros.MARKER,
    "/firstlap/centerline": ros.PATH,
    "/firstlap/path": ros.PATH,
    "/firstlap/trajectory": ros.CLOUD,
    "/firstlap/lookahead": ros.POINT,
    "/firstlap/status": ros.DIAGNOSTICS,
    "/firstlap/numbers": ros.ARRAY,
}
LATCHED = (
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n"
    "    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false"
)
"""QoS of /tf_static, so that a player publishes it to late subscribers."""


@dataclass(frozen=True)
class Batch:
    """Consecutive scans with their results.

    times: (N,) [ns] of the last beams; scan_time: [s] between two scans; ranges: N arrays; headers (N, 5),
    measured (N, 3) as in Recording; truth: poses (N, 3) in the map
    with speed and yaw rate (N, 2), or None; columns: of the steps, as in `_core.replay`.
    """

    times: npt.NDArray[np.int64]
    scan_time: float
    ranges: Any
    headers: Floats
    measured: Floats
    truth: tuple[Floats, Floats] | None
    columns: Columns


class LogWriter:
    """Writes batches in order; `close`, or leaving the `with` block, waits until everything is written.

    The file is written during the race, so that the part before a crash, or before the disk was full, can be replayed.
    A write error is raised as InputError by the next `put` or by `close`; the constructor raises it for a file that
    another process is writing.
    """

    def __init__(self, path: str | Path, about: About) -> None:
        self.path = check_writable(path, LOGS)
        self._file = _open_alone(self.path)
        self._about = about
        self._queue: queue.SimpleQueue[Batch | None] = queue.SimpleQueue()
        self._waiting = 0
        self._room = threading.Condition()
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="log writer", daemon=True)
        self._thread.start()

    def put(self, batch: Batch) -> None:
        """Queues a batch; waits only if the queue is full. Raises InputError."""
        with self._room:
            self._room.wait_for(lambda: self._waiting < WAITING or self._error is not None)
            self._waiting += len(batch.times)
        self._check()
        self._queue.put(batch)

    def close(self) -> None:
        """Waits for the queued batches and finishes the file. Raises InputError."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()
        try:
            self._file.close()
        except OSError as error:
            self._error = self._error or error
        self._check()

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except InputError:
            if kind is None:
                raise

    def _check(self) -> None:
        if isinstance(self._error, OSError):
            reason = self._error.strerror or self._error
            raise InputError(f"{self.path}: cannot be written ({reason}); the log ends there")
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        try:
            log = _Log(self._file, self._about)
            while True:
                try:
                    batch = self._queue.get(timeout=FLUSH_EVERY)
                except queue.Empty:
                    log.flush()
                    continue
                if batch is None:
                    break
                log.add(batch)
                with self._room:
                    self._waiting -= len(batch.times)
                    self._room.notify()
            log.finish()
        except BaseException as error:  # raised in the other thread
            with self._room:
                self._error = error
                self._room.notify()


def _open_alone(path: Path) -> IO[bytes]:
    """Opens the file, empty, and locked until it is closed. Raises InputError, also if another process is writing
    it."""
    try:
        file = os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT, ANYBODY), "wb")
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None
    try:
        lock_open_file(file, path, f"{path}: is being written by another process; expected another file name")
        if stat.S_ISREG(os.fstat(file.fileno()).st_mode):  # a device or a pipe cannot be truncated
            file.truncate()
    except BaseException:
        file.close()
        raise
    return file


class _Log:
    """The content of the file."""

    def __init__(self, file: Any, about: About) -> None:
        self._writer = Writer(file, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=f"firstlap {about.version}")
        self._writer.add_metadata(RECORD, about.to_metadata())
        self._channels = {topic: self._register(topic, kind) for topic, kind in TOPICS.items()}
        car = about.setup.params(about.car.core)
        self._laser = np.array([*laser_of(car.values()["car"]), 0.0])
        self._odom = np.zeros(3)
        self._last: tuple[int, float, float] | None = None
        self._flushed = time.monotonic()
        self._writer.flush()  # type: ignore[no-untyped-call]

    def _register(self, topic: str, kind: str) -> int:
        text = typestore().generate_msgdef(kind, ros_version=2)[0]
        schema = self._writer.register_schema(kind, "ros2msg", text.encode())
        qos = LATCHED if topic == "/tf_static" else ""
        return self._writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": qos})

    def add(self, batch: Batch) -> None:
        columns = batch.columns
        sequences = {name: rows_of(columns, name) for name in ("left", "right", "line", "path")}
        traced = len(columns["ahead"]) > 0
        for i, nanoseconds in enumerate(batch.times.tolist()):
            self._measured(batch, i, nanoseconds)
            self._put("/drive", nanoseconds, ros.drive(nanoseconds, columns["speed"][i], columns["steering_angle"][i]))
            if traced:
                self._results(columns, i, nanoseconds, {name: rows[i] for name, rows in sequences.items()})
            if time.monotonic() - self._flushed > FLUSH_EVERY:
                self.flush()

    def _put(self, topic: str, nanoseconds: int, data: bytes) -> None:
        self._writer.add_message(self._channels[topic], nanoseconds, data, nanoseconds)

    def _measured(self, batch: Batch, i: int, now: int) -> None:
        speed, yaw_rate, steering_angle = batch.measured[i].tolist()
        if self._last is None:
            self._put("/tf_static", now, ros.transforms(now, {(ros.BASE, ros.LASER): self._laser}))
        self._dead_reckon(now, speed, yaw_rate)
        self._put("/scan", now, ros.scan(now, batch.ranges[i], batch.headers[i], batch.scan_time))
        self._put("/odom", now, ros.odometry(now, ros.ODOM, self._odom, speed, yaw_rate))
        self._put("/joint_states", now, ros.joint_state(now, steering_angle))
        frames = {(ros.ODOM, ros.BASE): self._odom}
        if batch.truth is not None:
            pose, motion = batch.truth[0][i], batch.truth[1][i]
            self._put("/ground_truth/odom", now, ros.odometry(now, ros.MAP, pose, *motion.tolist()))
            frames[ros.MAP, ros.ODOM] = _before(pose, self._odom)
        self._put("/tf", now, ros.transforms(now, frames))

    def _dead_reckon(self, now: int, speed: float, yaw_rate: float) -> None:
        """The pose by dead reckoning."""
        if self._last is not None:
            before, speed_before, yaw_rate_before = self._last
            dt = (now - before) / 1e9
            turn, way = 0.5 * (yaw_rate + yaw_rate_before) * dt, 0.5 * (speed + speed_before) * dt
            yaw = self._odom[2] + 0.5 * turn
            self._odom = self._odom + np.array([way * np.cos(yaw), way * np.sin(yaw), turn])
        self._last = (now, speed, yaw_rate)

    def _results(self, columns: Columns, i: int, now: int, rows: dict[str, Floats]) -> None:
        for side in ("left", "right"):
            self._put("/firstlap/walls", now, ros.wall(now, side, rows[side]))
        self._put("/firstlap/centerline", now, ros.centerline(now, rows["line"]))
        self._put("/firstlap/path", now, ros.path(now, rows["path"][:, 1:4]))
        self._put("/firstlap/trajectory", now, ros.trajectory(now, rows["path"]))
        if len(rows["path"]):
            self._put("/firstlap/lookahead", now, ros.lookahead(now, columns["lookahead"][i]))
        self._put("/firstlap/status", now, ros.status(now, int(columns["status"][i])))
        self._put("/firstlap/numbers", now, ros.numbers(np.array([columns[name][i] for name in ros.NUMBERS])))

    def flush(self) -> None:
        """Flushes everything written so far."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._flushed = time.monotonic()

    def finish(self) -> None:
        """Writes the index and the end of the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]


def _before(pose: Floats, odom: Floats) -> Floats:
    """The transform t with pose = t * odom."""
    yaw = pose[2] - odom[2]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([pose[0] - c * odom[0] + s * odom[1], pose[1] - s * odom[0] - c * odom[1], yaw])
