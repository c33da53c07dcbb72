"""The driver's own thoughts for the pit wall, on ~/trace: only while somebody listens, and no oftener than asked."""

from __future__ import annotations

import array
import os
import time
from typing import Any

from std_msgs.msg import UInt8MultiArray

from firstlap.ros.node_parameters import value_of
from firstlap.ros.qos import NEWEST
from firstlap.ros.trace_message import TraceHeader, encode

EARLY = 0.1
"""Part of a period that a trace may come before its time: scans are not to the microsecond."""


class Traces:
    """Publishes for a driving node."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publisher = node.create_publisher(UInt8MultiArray, "~/trace", NEWEST)
        self._born = f"{os.getpid()}-{time.time_ns()}"
        self._next = 0.0

    def publish(self, state: tuple[float, float, float], stamp: float, spent: float, sent: tuple[float, float]) -> None:
        """After a step: state that it was given, end of its scan [s], time that it took [s], command that is sent."""
        if self._wanted():
            self._send(self._told(state, stamp, spent, "", sent), self._node.driving.handle.trace)

    def stands(self) -> None:
        """While the car may not drive: why."""
        if self._wanted():
            node = self._node
            why = (node.watchdog.tripped or "not armed") if node.active else "the node is not active"
            self._send(self._told(node.state.now(), node.now(), 0.0, why, (0.0, node.state.commanded)), {})

    def _wanted(self) -> bool:
        now, rate = time.monotonic(), value_of(self._node, "trace_rate")
        if rate <= 0.0 or now < self._next - EARLY / rate or self._publisher.get_subscription_count() == 0:
            return False
        self._next = max(self._next + 1.0 / rate, now)
        return True

    def _told(
        self, state: tuple[float, float, float], stamp: float, spent: float, why: str, sent: tuple[float, float]
    ) -> TraceHeader:
        """why: the car may not drive; nothing where it may."""
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

    def _send(self, told: TraceHeader, trace: Any) -> None:
        try:
            message = encode(told, trace)
        except ValueError as error:
            self._node.get_logger().error(str(error), throttle_duration_sec=5.0)
            return
        self._publisher.publish(UInt8MultiArray(data=array.array("B", message)))
