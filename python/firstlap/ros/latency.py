"""Measures the latency from a scan to its drive command, over DDS and between two processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.config.setup_file import Setup
from firstlap.ros.diagnostics import MISSED, missed_between
from firstlap.ros.domains import own_domain
from firstlap.sim.race import start_race
from firstlap.tracks.library import load_track

SCANS = 600
"""Number of recorded scans, played in a loop."""
WARM_UP = 2.0
"""[s] Warm-up, not measured; long enough for the node's first diagnostics."""
FASTEST = 20.0
"""[m/s] The node's speed limit; commands have no effect on the played scans."""
STOPPED = 10
"""Number of consecutive stop commands after which the node is resumed."""
READY = 30.0
"""[s] Timeout of the driving node's start."""
LAST_ANSWERS = 1.0
"""[s] Timeout for the answers to the last scans."""
BINS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0)
"""[ms] upper edges of the histogram."""


@dataclass
class Latency:
    """scan_to_drive: [ms] one per command. node: its own diagnostics. memory: [MB] of the node, once a second. stops:
    number of stops on an overloaded machine, after which the node was resumed. unsent: scans that were sent so late
    that the node counts them as missed. missed_before: scans missed during the warm-up."""

    scans: int = 0
    scan_to_drive: list[float] = field(default_factory=list)
    node: dict[str, str] = field(default_factory=dict)
    load: tuple[float, float] = (0.0, 0.0)
    memory: list[float] = field(default_factory=list)
    stops: int = 0
    unsent: int = 0
    missed_before: int = 0

    @property
    def missed(self) -> int:
        """Number of scans that were sent but not received by the node."""
        return max(0, self.missed_in_all - self.missed_before - self.unsent)

    @property
    def missed_in_all(self) -> int:
        """Number of missed scans since the node's start, as it counts them."""
        return int(self.node.get(MISSED, "0"))

    def summary(self) -> dict[str, Any]:
        """The result for --json; times are None without any command."""
        times: dict[str, float | None] = dict.fromkeys(("p50", "p90", "p99", "max"))
        if self.scan_to_drive:
            found = np.percentile(self.scan_to_drive, (50, 90, 99, 100))
            times = {name: float(value) for name, value in zip(times, found, strict=True)}
        return {
            "scans": self.scans,
            "answered": len(self.scan_to_drive),
            "stops": self.stops,
            "missed": self.missed,
            "unsent": self.unsent,
            "scan_to_drive_ms": times,
            "node_us": self.node,
            "load": {"before": self.load[0], "after": self.load[1], "cores": os.cpu_count()},
            "memory_mb": {"first": self.memory[0], "last": self.memory[-1]} if self.memory else None,
            "histogram": self.histogram(),
        }

    def histogram(self) -> list[tuple[float | None, int]]:
        """(upper edge [ms], number of commands) of each bin; the last bin has no edge."""
        edges = np.array([0.0, *BINS, np.inf])
        counts, _ = np.histogram(self.scan_to_drive, edges)
        return [(edge, int(count)) for edge, count in zip((*BINS, None), counts, strict=True)]


def lap_of_scans(setup: Setup, track: str) -> tuple[list[npt.NDArray[np.float32]], list[tuple[float, float]], Any]:
    """Scans, (speed [m/s], yaw rate [rad/s]) and the scan header of a simulated race."""
    kind = driver_kind(setup.driver)
    car = load_car("default")
    handle = kind.make(setup.params(car.core), car, Preparation())
    race = start_race(load_track(track), handle, car, laps=1000)
    scans, states = [], []
    for _ in range(SCANS):
        race.advance(1)
        scans.append(race.scan())
        states.append((race.measured().speed, race.measured().yaw_rate))
    return [scan.ranges for scan in scans], states, scans[-1].header


def measure(
    setup: Setup, track: str, seconds: float, rate: float, progress: Callable[[float], object] | None = None
) -> Latency:
    """Starts a driving node in a separate domain and plays scans to it. Raises InputError."""
    played = lap_of_scans(setup, track)
    with TemporaryDirectory() as folder, own_domain() as domain:
        os.environ.update({"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
        os.environ["XDG_RUNTIME_DIR"] = folder  # ignores the state that earlier nodes have left
        chosen = Path(folder) / "setup.yaml"
        chosen.write_text(_as_yaml(setup))
        command = [
            *(sys.executable, "-c", "from firstlap_command import main; main()"),
            *("drive", "--go", "--setup", str(chosen)),
            *("--ros-args", "--log-level", "error", "-p", "laser_from_tf:=false", "-p", f"speed_limit:={FASTEST}"),
        ]
        node = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            return _play(played, node, seconds, rate, progress)
        finally:
            node.terminate()
            try:
                node.wait(5.0)
            except subprocess.TimeoutExpired:
                node.kill()


def _as_yaml(setup: Setup) -> str:
    sections: dict[str, Any] = {"driver": setup.driver} if setup.driver != "local" else {}
    for (section, name), value in setup.given.items():
        sections.setdefault(section, {})[name] = value
    return json.dumps(sections or {"stanley": {}})


def _memory(process: int) -> list[float]:
    """Resident memory [MB], if the system provides it."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except OSError:
        return []
    return [pages * os.sysconf("SC_PAGE_SIZE") / 1e6]


class _Player:
    """Publishes scans and odometry to a driving node, and receives its commands. found: result. rate: [Hz]."""

    def __init__(self, found: Latency, rate: float) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self._found, self._rate = found, rate
        self.counting, self.answered_at = False, -1
        self.sent = 0
        self._playing, self._stopped, self._now = True, 0, 0.0
        self._unanswered: dict[int, float] = {}
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("firstlap_latency", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._connect()

    def _connect(self) -> None:
        from ackermann_msgs.msg import AckermannDriveStamped
        from diagnostic_msgs.msg import DiagnosticArray
        from nav_msgs.msg import Odometry
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import LaserScan
        from std_srvs.srv import Trigger

        self._scan_out = self._node.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        self._odom_out = self._node.create_publisher(Odometry, "odom", qos_profile_sensor_data)
        self._node.create_subscription(AckermannDriveStamped, "drive", self._on_drive, 10)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self._resume = self._node.create_client(Trigger, "firstlap_drive/resume")

    def _on_drive(self, message: Any) -> None:
        began = self._unanswered.pop(_key(message.header.stamp), None)
        if began is not None and self.counting:
            self._found.scan_to_drive.append(1e3 * (time.perf_counter() - began))
        self._stopped = self._stopped + 1 if began is None else 0  # the watchdog's stops answer no scan
        if self._stopped == STOPPED:
            self._found.stops += self.counting and self._playing
            self._resume.call_async(self._resume.srv_type.Request())
            self._stopped = 0

    def _on_diagnostics(self, message: Any) -> None:
        values = {value.key: value.value for value in message.status[0].values}
        self._found.node = {name: value for name, value in values.items() if "[us]" in name or name == MISSED}

    def spin(self, seconds: float) -> None:
        """Receives messages for at most this time [s]."""
        self._executor.spin_once(timeout_sec=seconds)

    def send(self, scan: npt.NDArray[np.float32], header: Any, state: tuple[float, float]) -> None:
        """Publishes one scan and the odometry at its time: speed [m/s], yaw rate [rad/s]."""
        from firstlap.ros import sim_messages as make

        before, self._now = self._now, self._node.get_clock().now().nanoseconds * 1e-9
        if self.counting:
            self._found.unsent += missed_between(self._now - before, 1.0 / self._rate)
        speed, yaw_rate = state
        self._odom_out.publish(make.odometry(self._now, "odom", "base_link", (0.0, 0.0, 0.0), (speed, 0.0, yaw_rate)))
        message = make.scan(self._now, "laser", scan, header, 1.0 / self._rate)
        self._unanswered[_key(message.header.stamp)] = time.perf_counter()
        self._scan_out.publish(message)
        self.sent += 1
        self._count()
        if len(self._unanswered) > SCANS:
            self._unanswered.pop(next(iter(self._unanswered)))

    def _count(self) -> None:
        """Counts scans after the warm-up, which begins with the first answer."""
        if self.answered_at < 0 and len(self._unanswered) < self.sent:
            self.answered_at = self.sent
        if not self.counting and 0 <= self.answered_at < self.sent - WARM_UP * self._rate:
            self.counting, self._found.missed_before = True, self._found.missed_in_all
        self._found.scans += self.counting

    def finish(self) -> None:
        """Receives the answers that are still on their way."""
        self._playing = False
        end = time.perf_counter() + LAST_ANSWERS
        while self._unanswered and time.perf_counter() < end:
            self.spin(0.05)

    def close(self) -> None:
        """Ends the node."""
        import rclpy

        self._executor.remove_node(self._node)
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def _key(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _play(played: Any, node: Any, seconds: float, rate: float, progress: Callable[[float], object] | None) -> Latency:
    scans, states, header = played
    found = Latency(load=(os.getloadavg()[0], 0.0))
    player = _Player(found, rate)
    total = int(seconds * rate)
    begin = due = time.perf_counter()
    try:
        while found.scans < total:
            wait = due - time.perf_counter()
            if wait > 0.0:
                player.spin(wait)
                continue
            if node.poll() is not None or (player.answered_at < 0 and due - begin > READY):
                raise InputError("the driving node did not start: run `firstlap drive` to see why")
            player.send(scans[player.sent % len(scans)], header, states[player.sent % len(states)])
            due = max(due + 1.0 / rate, time.perf_counter())
            if player.counting and found.scans % round(max(rate, 1.0)) == 1:
                found.memory += _memory(node.pid)
            if player.counting and progress:
                progress(found.scans / total)
        player.finish()
    finally:
        player.close()
    found.load = (found.load[0], os.getloadavg()[0])
    return found
