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


def _play(played: Any, node: Any, seconds: float, rate: float, progress: Callable[[float], object] | None) -> Latency:
    import rclpy
    from ackermann_msgs.msg import AckermannDriveStamped
    from diagnostic_msgs.msg import DiagnosticArray
    from nav_msgs.msg import Odometry
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.qos import qos_profile_sensor_data
    from sensor_msgs.msg import LaserScan
    from std_srvs.srv import Trigger

    from firstlap.ros import sim_messages as make

    scans, states, header = played
    found = Latency(load=(os.getloadavg()[0], 0.0))
    sent: dict[int, float] = {}
    counting, playing, stopped = False, True, 0
    context = rclpy.Context()
    rclpy.init(context=context)
    probe = rclpy.create_node("firstlap_latency", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(probe)

    def key(stamp: Any) -> int:
        return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)

    def on_drive(message: Any) -> None:
        nonlocal stopped
        began = sent.pop(key(message.header.stamp), None)
        if began is not None and counting:
            found.scan_to_drive.append(1e3 * (time.perf_counter() - began))
        stopped = stopped + 1 if began is None else 0  # the watchdog's stops have no scan
        if stopped == STOPPED:
            found.stops += counting and playing
            resume.call_async(Trigger.Request())
            stopped = 0

    def on_diagnostics(message: Any) -> None:
        values = {value.key: value.value for value in message.status[0].values}
        found.node = {name: value for name, value in values.items() if "[us]" in name or name == MISSED}

    scan_out = probe.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
    odom_out = probe.create_publisher(Odometry, "odom", qos_profile_sensor_data)
    probe.create_subscription(AckermannDriveStamped, "drive", on_drive, 10)
    probe.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 10)
    resume = probe.create_client(Trigger, "firstlap_drive/resume")
    total, i, answered_at, now = int(seconds * rate), 0, None, 0.0
    begin = due = time.perf_counter()
    try:
        while found.scans < total:
            wait = due - time.perf_counter()
            if wait > 0.0:
                executor.spin_once(timeout_sec=wait)
                continue
            if node.poll() is not None or (answered_at is None and due - begin > READY):
                raise InputError("the driving node did not start: run `firstlap drive` to see why")
            before, now = now, probe.get_clock().now().nanoseconds * 1e-9
            if counting:
                found.unsent += missed_between(now - before, 1.0 / rate)
            speed, yaw_rate = states[i % len(states)]
            odom_out.publish(make.odometry(now, "odom", "base_link", (0.0, 0.0, 0.0), (speed, 0.0, yaw_rate)))
            message = make.scan(now, "laser", scans[i % len(scans)], header, 1.0 / rate)
            sent[key(message.header.stamp)] = time.perf_counter()
            scan_out.publish(message)
            i += 1
            due = max(due + 1.0 / rate, time.perf_counter())
            if answered_at is None and len(sent) < i:
                answered_at = i
            if not counting and answered_at is not None and i > answered_at + WARM_UP * rate:
                counting, found.missed_before = True, found.missed_in_all
            if counting:
                found.scans += 1
                if found.scans % round(max(rate, 1.0)) == 1:
                    found.memory += _memory(node.pid)
                if progress:
                    progress(found.scans / total)
            if len(sent) > SCANS:
                sent.pop(next(iter(sent)))
        playing = False
        end = time.perf_counter() + 1.0
        while sent and time.perf_counter() < end:
            executor.spin_once(timeout_sec=0.05)
    finally:
        executor.remove_node(probe)
        probe.destroy_node()
        rclpy.shutdown(context=context)
    found.load = (found.load[0], os.getloadavg()[0])
    return found
