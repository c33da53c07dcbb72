"""The driving node's callbacks in the driving thread: all are short, and none imports anything."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from sensor_msgs.msg import Imu, JointState, Joy
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

import firstlap
from firstlap.drivers.driving import Driving
from firstlap.ros import sim_messages as make
from firstlap.ros.domains import own_domain
from firstlap.ros.drive_node import DriveNode
from firstlap.ros.latency import lap_of_scans
from firstlap.ros.process import pause_gc
from firstlap.ros.qos import NEWEST, NEWEST_LATCHED
from firstlap.ros.trace_message import TRACE, topics_of
from firstlap.ros.traces import CLASSES

pytestmark = pytest.mark.dds

TRACES = f"/firstlap_drive/{TRACE}"
LIMIT = 0.02
"""[s] Maximum CPU time of a callback: less than a scan period at 40 Hz. One import of a part of numpy took 0.046 s."""
STEPS = 400
PERIOD = 0.025
MAX_AGE = 5.0
PARAMETERS = {
    "laser_from_tf": False,
    "max_age": MAX_AGE,
    "scan_timeout": 1.0,
    "odom_timeout": 1.0,
    "pause_limit": 1.0,
    "imu_topic": "imu",
    "steering_topic": "joints",
    "deadman_topic": "joy",
    "deadman_button": 1,
    "marker_rate": 100.0,
    "trace_rate": 100.0,
}


class Bench:
    """A driving node and a subscriber in this process; calls the callbacks and records their CPU times."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        given = [Parameter(name, value=value) for name, value in PARAMETERS.items()]
        setup = firstlap.load_setup("sure")
        self.node = DriveNode(Driving(setup), context=self.context, parameter_overrides=given)
        self.watcher = rclpy.create_node("watcher", context=self.context)
        self.button = self.watcher.create_publisher(Bool, "/emergency_stop", NEWEST_LATCHED)
        self.heard = [
            self.watcher.create_subscription(MarkerArray, "/firstlap_drive/markers", lambda _: None, 1),
        ]
        self.heard += [
            self.watcher.create_subscription(CLASSES[kind], f"{TRACES}/{name}", lambda _: None, NEWEST)
            for name, kind in topics_of("local").items()
        ]
        self.scans, self.states, self.header = lap_of_scans(setup, "arena")
        self.pose = (0.0, 0.0, 0.0)
        self.began = 0.0
        self.times: dict[Any, list[float]] = {}

    def call(self, callback: Callable[..., Any], *arguments: Any) -> Any:
        """Calls and times a callback."""
        began = time.thread_time()
        found = callback(*arguments)
        self.times.setdefault(callback, []).append(time.thread_time() - began)
        return found

    def ask(self, callback: Callable[..., Any]) -> Any:
        """Calls and times a service callback."""
        return self.call(callback, Trigger.Request(), Trigger.Response())

    def sense(self, i: int) -> None:
        """Sensor messages and timers of step i."""
        node, stamp = self.node, self.began + PERIOD * i
        speed, yaw_rate = self.states[i % len(self.states)]
        x, y, yaw = self.pose
        middle = yaw + 0.5 * yaw_rate * PERIOD
        step = speed * PERIOD
        self.pose = (x + step * math.cos(middle), y + step * math.sin(middle), yaw + yaw_rate * PERIOD)
        odometry: Odometry = make.odometry(stamp, "odom", "base_link", self.pose, (speed, 0.0, yaw_rate))
        imu: Imu = make.imu(stamp, "base_link", yaw_rate, (0.0, 0.0))
        joints: JointState = make.joints(stamp, 0.0)
        place = make.transform(stamp, "odom", "base_link", (0.1 * i, 0.0, 0.0))
        self.call(node.on_deadman, Joy(buttons=[0, 1]))
        self.call(node.on_odometry, odometry)
        self.call(node.on_imu, imu)
        self.call(node.on_steering, joints)
        self.call(node.frames.add, TFMessage(transforms=[place]))
        self.call(node.on_scan, make.scan(stamp, "laser", self.scans[i % len(self.scans)], self.header, PERIOD))
        self.call(node.on_check)
        if i % 20 == 0:
            self.call(node.on_heartbeat)
            self.call(node.other_drivers.on_claim, String(data=node.other_drivers._claims.own(True).encode()))
        if i % 40 == 39:
            self.call(node.health.publish)

    def missed(self) -> list[Any]:
        """Callbacks of the node that were never called."""
        node = self.node
        ours = [*node.subscriptions, *node.timers, *node.services]
        callbacks = {one.callback for one in ours if getattr(one.callback, "__module__", "").startswith("firstlap")}
        return [one for one in callbacks if one not in self.times]

    def close(self) -> None:
        """Destroys the nodes."""
        self.watcher.destroy_node()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def bench(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    """A bench in a separate domain."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with own_domain() as domain:
        made = Bench(domain)
        yield made
        made.close()


def test_no_callback_takes_long_and_none_imports_anything(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    node = bench.node
    node.trigger_configure()
    monkeypatch.setattr("firstlap.ros.other_drivers.SETTLE", 0.0)
    for topic in ("/firstlap_drive/markers", *(f"{TRACES}/{name}" for name in topics_of("local"))):
        while not node.count_subscribers(topic):
            time.sleep(0.02)
    pause_gc()
    before = set(sys.modules)
    bench.began = node.now() - 0.9 * MAX_AGE  # the test runs faster than real time
    bench.call(node.on_deadman, Joy(buttons=[0, 0]))
    for i in range(20):
        bench.sense(i)
    assert bench.ask(node.on_go).success, node.refusal
    for i in range(20, STEPS):
        bench.sense(i)
        if not node.watchdog.armed:  # the machine paused this process
            assert bench.ask(node.on_go).success
        if i % 100 == 50:
            values = [
                Parameter("velocity_profile.v_max", value=4.0 + 0.001 * i),
                Parameter("stanley.k_dist", value=1.1),
            ]
            assert bench.call(node.on_parameters, values).successful
    assert bench.ask(node.on_stop).success
    assert bench.ask(node.on_resume).success
    for word in (True, False):
        bench.call(node.emergency.on_message, Bool(data=word))
    bench.call(node.emergency.on_latched, Bool(data=False))
    assert node.health.counts["drive"] > 0.5 * STEPS
    assert set(sys.modules) == before
    assert bench.missed() == []
    longest = {f"{one.__self__.__class__.__name__}.{one.__name__}": max(took) for one, took in bench.times.items()}
    assert {name: took for name, took in longest.items() if took > LIMIT} == {}
