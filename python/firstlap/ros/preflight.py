"""Checks of the live topics before the first drive: each is OK or says what is wrong.

The checks are pure functions of the received messages, which `Listener` collects. They use the driving node's own
functions and parameters.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.text import to_side
from firstlap.config.car_file import CAR_FIELDS
from firstlap.perception.scan import LASER, Judgment, Mount
from firstlap.ros.periods import Bounds, Period, rate_reason, timeout_of
from firstlap.ros.safety import Stamps

STANDSTILL = 0.1
"""[m/s], [rad/s] Maximum values of a stationary car."""
MIN_OFFSET = 0.005
"""[m] Lateral offset of the laser from which it is reported."""
TURNED = 0.25
"""[rad] Minimum rotation for comparing signs."""
SCALE = 0.1
"""Maximum relative difference of commanded speed, measured speed and speed from the scans."""
ROLLING, STEADY = 2.0, 1.0
"""[s] Duration of the rolling test, and time after which the speed is measured."""
NAMED = 3.0
"""[s] Maximum delay of a node's name after its topics."""
UNNAMED = "_NODE_NAME_UNKNOWN_"
"""rclpy's name of a node until then."""
CAP = 1.0
"""[m] Maximum error per beam in scan matching."""
FAR = 30.0
"""[m] Range of a beam without a return in scan matching."""
OVERLAP = 20
"""Minimum number of overlapping beams in scan matching."""
WIDEST_TURN = 1.2
"""[rad] Maximum rotation in scan matching."""


OURS = (
    *("scan_topic", "odom_topic", "drive_topic", "base_frame", "laser_from_tf", "laser_yaw"),
    *("scan_timeout", "odom_timeout", "max_age"),
)
"""Parameters of the driving node that the checks use."""


class Check(NamedTuple):
    """One line of the report. good: None if it could not be checked."""

    name: str
    good: bool | None
    said: str


class Sample(NamedTuple):
    """The messages of a topic: arrival time and age [s] of each, and the last message."""

    arrivals: list[float]
    ages: list[float]
    last: Any

    @property
    def rate(self) -> float:
        """Rate [Hz]."""
        count = len(self.arrivals)
        return (count - 1) / (self.arrivals[-1] - self.arrivals[0]) if count > 1 else 0.0

    @property
    def period(self) -> float:
        """Period [s] as measured by the driving node; 0 with too few messages."""
        period = Period()
        for arrival in self.arrivals:
            period.add(arrival)
        return period.seconds


def check_rate(name: str, topic: str, sample: Sample, given: float, bounds: Bounds) -> Check:
    """Checks that a topic arrives, fast enough and without gaps. given, bounds: as in `timeout_of`."""
    if not sample.arrivals:
        return Check(name, False, f"nothing on {topic}: is the driver running, and is the topic name right?")
    timeout = timeout_of(given, sample.period, bounds)
    reason = rate_reason(topic, sample.period, timeout)
    if reason:
        return Check(name, False, reason)
    gap = float(np.diff(sample.arrivals).max()) if len(sample.arrivals) > 1 else math.inf
    if gap > timeout:
        return Check(name, False, f"a gap of {1e3 * gap:.0f} ms in {topic}; the timeout is {1e3 * timeout:.0f} ms")
    return Check(name, True, f"{sample.rate:.1f} Hz on {topic}; timeout {1e3 * timeout:.0f} ms")


def check_stamps(name: str, sample: Sample, max_age: float, took: float = 0.0) -> Check:
    """Checks that the clocks agree. max_age, took: as in `Stamps`."""
    if not sample.ages:
        return Check(name, None, "no data")
    age = float(np.median(sample.ages))
    reason = Stamps(max_age).reason(-age, 0.0, took)
    if reason:
        return Check(name, False, f"{reason}: synchronize the clocks, or set max_age:=0.0 if that is impossible")
    return Check(name, True, f"{1e3 * age:.0f} ms old")


def check_scan(scan: _core.LaserScan | None, judgment: Judgment) -> Check:
    """Checks that the scan is usable, and reports its remarks."""
    if scan is None:
        return Check("scan beams", None, "no data")
    if judgment.reason:
        return Check("scan beams", False, judgment.reason)
    share = f"{len(scan.ranges)} beams, {100 * float(scan.returns().mean()):.0f} % return"
    return Check("scan beams", True, "; ".join((share, *judgment.remarks)))


def check_mount(mount: Mount, base: str) -> Check:
    """Checks the LiDAR mounting."""
    try:
        for name, value in zip(LASER, (mount.x, mount.y), strict=True):
            CAR_FIELDS.check(CAR_FIELDS.find(f"geometry.{name}", "laser"), value, "laser")
    except InputError as error:
        return Check("laser mounting", False, str(error))
    aside = f", {to_side(mount.y, 'left', 'right', '.2f')} of its center" if abs(mount.y) >= MIN_OFFSET else ""
    where = f"{to_side(mount.x, 'ahead', 'behind', '.2f')} of {base}{aside}, yaw {math.degrees(mount.yaw):.0f}°"
    return Check("laser mounting", True, where + (", upside down" if mount.upside_down else ""))


def check_standstill(sample: Sample) -> Check:
    """Checks that the odometry of a stationary car is zero."""
    if sample.last is None:
        return Check("standstill", None, "no data")
    twist = sample.last.twist.twist
    if not (math.isfinite(twist.linear.x) and math.isfinite(twist.angular.z)):
        return Check("standstill", False, "odometry is not finite")
    if abs(twist.linear.x) > STANDSTILL or abs(twist.angular.z) > STANDSTILL:
        said = f"odometry reports {twist.linear.x:.2f} m/s, {twist.angular.z:.2f} rad/s"
        return Check("standstill", False, f"{said}: if the car is not moving, calibrate the speed offset and the gyro")
    return Check("standstill", True, "odometry reports standstill")


def check_drive(topic: str, listeners: int, others: list[str]) -> Check:
    """Checks that commands have a subscriber and no other publisher."""
    if listeners == 0:
        return Check("drive", False, f"no subscriber on {topic}: start the mux and the motor driver")
    if others:
        return Check("drive", False, f"also publishing on {topic}: {', '.join(others)}; stop them")
    return Check("drive", True, f"{listeners} subscribers on {topic}")


def turn_between(before: npt.NDArray[np.float32], after: npt.NDArray[np.float32], step: float, most: float) -> float:
    """Rotation [rad] of the laser, left positive, between two scans from about the same position, by scan matching.

    step: angle between beams [rad]. most: maximum rotation [rad], either sign.
    """
    a, b = (np.where(np.isfinite(one), one, FAR).astype(np.float64) for one in (before, after))
    reach = min(int(most / abs(step)), len(a) - OVERLAP)
    errors = {}
    for k in range(-reach, reach + 1):
        old, new = (a[k:], b[: len(b) - k]) if k >= 0 else (a[:k], b[-k:])
        errors[k] = float(np.minimum(np.abs(old - new), CAP).mean())
    return min(errors, key=lambda k: errors[k]) * step


def check_turn(odometry_turn: float, laser_turn: float) -> Check:
    """Checks that odometry and laser agree on a left turn."""
    if abs(odometry_turn) < TURNED and abs(laser_turn) < TURNED:
        return Check("turn left", None, "the car was not turned")
    said = f"odometry {math.degrees(odometry_turn):.0f}°, laser {math.degrees(laser_turn):.0f}°, left positive"
    if odometry_turn < TURNED:
        return Check("turn left", False, f"{said}: the odometry's yaw rate has the wrong sign or is missing")
    if laser_turn < 0.5 * TURNED:
        return Check("turn left", False, f"{said}: the scan runs in the wrong direction; is the laser upside down?")
    if not 0.6 < laser_turn / odometry_turn < 1.6:
        return Check("turn left", False, f"{said}: they differ too much; calibrate the yaw rate")
    return Check("turn left", True, said)


def check_forward(speed: float, commanded: float) -> Check:
    """Checks the odometry of a car that was commanded to roll forward."""
    said = f"commanded {commanded:.1f} m/s, odometry reports {speed:.2f} m/s"
    if speed < -0.2 * commanded:
        return Check("drive forward", False, f"{said}: the motor or the measured speed has the wrong sign")
    if speed < 0.3 * commanded:
        return Check("drive forward", False, f"{said}: is the motor enabled, and the emergency stop released?")
    if speed > 1.7 * commanded:
        return Check("drive forward", False, f"{said}: calibrate the speed gain")
    return Check("drive forward", True, said)


def check_scale(commanded: float, measured: float, scanned: float | None) -> Check:
    """Compares commanded speed, measured speed and, if available, speed from the scans [m/s] at steady motion."""
    check = check_forward(measured, commanded)
    if not check.good:
        return check
    said = f"commanded {commanded:.2f} m/s, odometry reports {measured:.2f} m/s"
    if scanned is None or scanned < STANDSTILL:  # on a stand, or in a bare corridor
        error = measured / commanded - 1.0
        if abs(error) > SCALE:
            return Check(check.name, False, f"{said}, {100.0 * error:+.0f} %: calibrate speed_to_erpm_gain")
        return Check(check.name, True, said)
    said = f"{said}, the scans show {scanned:.2f} m/s"
    if abs(measured / scanned - 1.0) > SCALE:
        error = measured / scanned - 1.0
        return Check(check.name, False, f"{said}: odometry reads {100.0 * error:+.0f} %, calibrate speed_to_erpm_gain")
    if abs(scanned / commanded - 1.0) > SCALE:
        error = scanned / commanded - 1.0
        return Check(check.name, False, f"{said}: the car drives {100.0 * error:+.0f} % relative to the command")
    return Check(check.name, True, said)


def check_agreement(remarks: tuple[str, ...], compared: tuple[str, ...]) -> Check:
    """Checks odometry against scans, its own poses and commands; arguments from OdometryWatch."""
    if remarks:
        return Check("odometry agrees", False, "; ".join(remarks))
    if not compared:
        return Check("odometry agrees", None, "nothing to compare with")
    return Check("odometry agrees", True, f"with {', '.join(compared)}")


class Listener:
    """A node that receives scans, odometry and TF, and can publish commands."""

    def __init__(self) -> None:
        from ackermann_msgs.msg import AckermannDriveStamped
        from nav_msgs.msg import Odometry
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import LaserScan
        from tf2_msgs.msg import TFMessage

        from firstlap.perception.frames import Frames
        from firstlap.ros.names import DRIVE
        from firstlap.ros.node_parameters import declare_entries
        from firstlap.ros.odometry_watch import OdometryWatch
        from firstlap.ros.qos import LATCHED

        self.node = Node("firstlap_preflight")
        declare_entries(self.node, [one for one in DRIVE if one.name in OURS])
        self.frames = Frames()
        self.scan, self.odom = Sample([], [], None), Sample([], [], None)
        self.watch = OdometryWatch()
        self._scan_period = Period()
        self.yaw = 0.0
        self._odom_time: float | None = None
        subscribe = self.node.create_subscription
        subscribe(LaserScan, self.value("scan_topic"), self._on_scan, qos_profile_sensor_data)
        subscribe(Odometry, self.value("odom_topic"), self._on_odometry, qos_profile_sensor_data)
        subscribe(TFMessage, "/tf_static", self.frames.add, LATCHED)
        subscribe(TFMessage, "/tf", self.frames.add, 100)
        self._command = AckermannDriveStamped
        self.drive: Any = None
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)

    def value(self, name: str) -> Any:
        """A parameter's value."""
        return self.node.get_parameter(name).value

    def _age(self, stamp: Any) -> float:
        from firstlap.ros.conversions import seconds

        return self.node.get_clock().now().nanoseconds * 1e-9 - seconds(stamp)

    def _on_scan(self, message: Any) -> None:
        now = time.monotonic()
        self._scan_period.add(now)
        self.scan.arrivals.append(now)
        self.scan.ages.append(self._age(message.header.stamp))
        self.scan = self.scan._replace(last=message)
        self._watch_scan(message)

    def _watch_scan(self, message: Any) -> None:
        """Adds a usable scan with known mounting to the odometry check."""
        from firstlap.ros.conversions import judged, sweep_of

        mount, place = self._laser()
        if place is not None and not place.good:
            return
        period = self._scan_period.seconds
        scan, judgment = judged(message, mount, period)
        if not judgment.reason:
            self.watch.add_scan(scan, self._when(message) + sweep_of(message, period), mount)
            self.watch.work()

    def _when(self, message: Any) -> float:
        """Time [s] of a message, as in the driving node."""
        from firstlap.ros.conversions import seconds

        return seconds(message.header.stamp) if self.value("max_age") > 0.0 else self._now()

    def _now(self) -> float:
        return float(self.node.get_clock().now().nanoseconds) * 1e-9

    def _on_odometry(self, message: Any) -> None:
        now = time.monotonic()
        if self._odom_time is not None:
            self.yaw += message.twist.twist.angular.z * min(now - self._odom_time, 0.2)
        self._odom_time = now
        self.odom.arrivals.append(now)
        self.odom.ages.append(self._age(message.header.stamp))
        self.odom = self.odom._replace(last=message)
        self.watch.add_odometry(self._when(message), message.twist.twist, message.pose.pose)

    def listen(self, seconds: float, over: Callable[[], bool] = lambda: False) -> None:
        """Receives messages for a duration, or until `over`."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not over():
            self.executor.spin_once(timeout_sec=0.02)

    def run_checks(self, seconds: float) -> list[Check]:
        """Runs all checks that need no motion."""
        from firstlap.ros.conversions import judged, sweep_of
        from firstlap.ros.periods import BOUNDS

        self.listen(10.0, lambda: bool(self.scan.arrivals and self.odom.arrivals))
        for sample in (self.scan, self.odom):
            sample.arrivals.clear()
            sample.ages.clear()
        self.listen(seconds)
        scan_topic, odom_topic, drive_topic = (self.value(f"{name}_topic") for name in ("scan", "odom", "drive"))
        period = self.scan.period
        took = max(sweep_of(self.scan.last, period), period) if self.scan.last else 0.0
        mount, place = self._laser()
        scan, judgment = None, Judgment("none", "", ())
        if self.scan.last:
            scan, judgment = judged(self.scan.last, mount, period)
        checks = [
            check_rate("scan", scan_topic, self.scan, self.value("scan_timeout"), BOUNDS["scan"]),
            check_stamps("scan clock", self.scan, self.value("max_age"), took),
            check_scan(scan, judgment),
            check_rate("odometry", odom_topic, self.odom, self.value("odom_timeout"), BOUNDS["odom"]),
            check_stamps("odometry clock", self.odom, self.value("max_age")),
            check_standstill(self.odom),
            check_agreement(self.watch.remarks, self.watch.compared),
        ]
        if place:
            checks.append(place)
        resolved = self.node.resolve_topic_name(drive_topic)
        self.listen(NAMED, lambda: UNNAMED not in self._commanders(resolved))
        others = [name for name in self._commanders(resolved) if name != "firstlap_preflight"]
        if "firstlap_drive" in others:
            others.remove("firstlap_drive")  # one driving node is intended; a second is not
        checks.append(check_drive(resolved, self.node.count_subscribers(resolved), others))
        return checks

    def _laser(self) -> tuple[Mount, Check | None]:
        """The LiDAR mounting (facing forward if unknown), and its check."""
        from firstlap.perception.frames import mount_of

        ahead = Mount(0.0, 0.0, float(self.value("laser_yaw")), False)
        if not (self.scan.last and self.value("laser_from_tf")):
            return ahead, None
        base, frame = self.value("base_frame"), self.scan.last.header.frame_id
        place = self.frames.find(base, frame)
        if place is None:
            said = f"no transform from {base} to {frame}: publish it, or set laser_from_tf:=false"
            return ahead, Check("laser mounting", False, said)
        try:
            mount = mount_of(place)
        except ValueError as error:
            return ahead, Check("laser mounting", False, str(error))
        return mount, check_mount(mount, base)

    def _commanders(self, topic: str) -> list[str]:
        """Names of the nodes that publish on a topic, one per publisher."""
        return sorted(str(one.node_name) for one in self.node.get_publishers_info_by_topic(topic))

    def command(self, speed: float, steering_angle: float, seconds: float, over: Callable[[], bool]) -> None:
        """Publishes a command at 20 Hz for a duration, then always stops the car."""
        self.drive = self.drive or self.node.create_publisher(self._command, self.value("drive_topic"), 1)
        self.listen(5.0, lambda: self.drive.get_subscription_count() > 0)
        end = time.monotonic() + seconds
        try:
            while time.monotonic() < end and not over():
                self._send(speed, steering_angle)
                self.listen(0.05)
        finally:
            for _ in range(10):
                self._send(0.0, steering_angle)
                self.listen(0.02)

    def _send(self, speed: float, steering_angle: float) -> None:
        message = self._command()
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.drive.speed, message.drive.steering_angle = speed, steering_angle
        self.drive.publish(message)
        self.watch.add_command(self._now(), speed)

    def forward(self, speed: float) -> Check:
        """Rolls forward and checks the steady speed."""
        began = self._now()
        measured: list[float] = []

        def note_speed() -> bool:
            if self.odom.last and self._now() - began > STEADY:
                measured.append(self.odom.last.twist.twist.linear.x)
            return False

        self.command(speed, 0.0, ROLLING, note_speed)
        steps = [one for one in self.watch.steps() if one.begin > began + STEADY and one.end < began + ROLLING]
        valid = [one for one in steps if one.tells_along]
        lasted = sum(one.end - one.begin for one in valid)
        scanned = sum(one.forward for one in valid) / lasted if lasted > 0.0 else None
        return check_scale(speed, float(np.mean(measured)) if measured else 0.0, scanned)

    def agrees(self) -> Check:
        """The odometry check after the movements."""
        return check_agreement(self.watch.remarks, self.watch.compared)

    def turned(self, move: Callable[[Callable[[], bool]], None]) -> Check:
        """Compares odometry and laser during a left turn, by `move` or by hand."""
        if self.scan.last is None:
            return Check("turn left", None, "no scan")
        (before, step), self.yaw = self._ranges(), 0.0
        move(lambda: abs(self.yaw) > 2.0 * TURNED)
        after, _ = self._ranges()
        if len(after) != len(before):  # resample to the previous number of beams over the same angle
            after = after[np.rint(np.linspace(0, len(after) - 1, len(before))).astype(int)]
        return check_turn(self.yaw, turn_between(before, after, step, WIDEST_TURN))

    def _ranges(self) -> tuple[npt.NDArray[np.float32], float]:
        """Ranges of the last scan [m], NaN without a return, and the angle between its beams [rad] as mounted."""
        from firstlap.ros.conversions import to_scan

        scan = to_scan(self.scan.last, self._laser()[0])
        return np.where(scan.returns(), scan.ranges, np.float32(np.nan)), scan.angle_increment

    def close(self) -> None:
        """Destroys the node."""
        self.executor.remove_node(self.node)
        self.node.destroy_node()
