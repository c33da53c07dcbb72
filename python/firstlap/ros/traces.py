"""Publishes the driver's trace under ~/trace, while there are subscribers and at `trace_rate` at most."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64MultiArray
from visualization_msgs.msg import Marker

from firstlap.recordings import log_messages as ros
from firstlap.ros.node_parameters import value_of
from firstlap.ros.qos import NEWEST
from firstlap.ros.trace_message import TRACE, TraceHeader, messages_of, topics_of

CLASSES: dict[str, Any] = {
    ros.DIAGNOSTICS: DiagnosticArray,
    ros.POINT: PointStamped,
    ros.PATH: Path,
    ros.CLOUD: PointCloud2,
    ros.ARRAY: Float64MultiArray,
    ros.MARKER: Marker,
}
EARLY = 0.1
"""Fraction of the period by which a trace may be early, to tolerate jitter of the scans."""


class Traces:
    """The trace publisher of a driving node."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publishers = {
            name: node.create_publisher(CLASSES[kind], f"~/{TRACE}/{name}", NEWEST)
            for name, kind in topics_of(node.driving.setup.driver).items()
        }
        self._born = f"{os.getpid()}-{time.time_ns()}"
        self._next = 0.0
        self._prepare()

    def _prepare(self) -> None:
        """Builds messages once in advance, because the first use loads modules, which takes too long while driving."""
        header = self._header((0.0, 0.0, 0.0), 0.0, 0.0, "", (0.0, 0.0))
        with suppress(ValueError):  # reported when it is to be published
            list(self._messages(header, self._node.driving.handle.trace, set(self._publishers)))

    def publish(self, state: tuple[float, float, float], stamp: float, spent: float, sent: tuple[float, float]) -> None:
        """Publishes a step: its input state, end of its scan [s], compute time [s], and published command."""
        if self._take_turn():
            self._send(self._header(state, stamp, spent, "", sent), self._node.driving.handle.trace)

    def publish_stopped(self) -> None:
        """Publishes why the car is stopped."""
        if self._take_turn():
            node = self._node
            why = (node.watchdog.tripped or "not armed") if node.active else "the node is not active"
            self._send(self._header(node.state.now(), node.now(), 0.0, why, (0.0, node.state.commanded[1])), {})

    def _subscribed(self) -> set[str]:
        """Names of the topics with subscribers."""
        return {name for name, publisher in self._publishers.items() if publisher.get_subscription_count()}

    def _take_turn(self) -> bool:
        """Whether this step is published; if so, the next one is due a period later."""
        now, rate = time.monotonic(), value_of(self._node, "trace_rate")
        if rate <= 0.0 or now < self._next - EARLY / rate or not self._subscribed():
            return False
        self._next = max(self._next + 1.0 / rate, now)
        return True

    def _header(
        self, state: tuple[float, float, float], stamp: float, spent: float, why: str, sent: tuple[float, float]
    ) -> TraceHeader:
        """The header. why: why the car may not drive; empty if it may."""
        driver = self._node.driving.setup.driver
        speed, yaw_rate, steering_angle, sent_speed, sent_angle = (float(value) for value in (*state, *sent))
        return TraceHeader(
            self._born,
            driver,
            stamp,
            speed,
            yaw_rate,
            steering_angle,
            1e6 * spent,
            not why,
            why,
            sent_speed,
            sent_angle,
        )

    def _send(self, header: TraceHeader, trace: Any) -> None:
        try:
            for name, message in self._messages(header, trace, self._subscribed()):
                self._publishers[name].publish(message)
        except ValueError as error:
            self._node.get_logger().error(f"the trace was not published: {error}", throttle_duration_sec=5.0)

    def _messages(self, header: TraceHeader, trace: Any, wanted: set[str]) -> Iterator[tuple[str, bytes]]:
        driving = self._node.driving
        frame, laser = value_of(self._node, "base_frame"), driving.laser or driving.laser_given
        return messages_of(header, trace, frame, laser, wanted)
