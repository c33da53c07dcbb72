"""Detects other driving nodes on the same drive topic, by claims on `<drive topic>/claim`."""

from __future__ import annotations

import os
import socket
import time
from typing import Any

from std_msgs.msg import String

from firstlap.ros.claims import SETTLE, Claims
from firstlap.ros.qos import NEWEST_LATCHED


class OtherDrivers:
    """Exchanges claims for a driving node that publishes on `topic`."""

    def __init__(self, node: Any, topic: str) -> None:
        who = f"{node.get_fully_qualified_name()}, process {os.getpid()} on {socket.gethostname()}"
        self._claims = Claims(time.time_ns(), who)
        self._began = time.monotonic()
        self._node = node
        self._publisher = node.create_publisher(String, f"{topic}/claim", NEWEST_LATCHED)
        node.create_subscription(String, f"{topic}/claim", self.on_claim, 10)

    def on_claim(self, message: Any) -> None:
        """Takes a claim, possibly this node's own."""
        try:
            self._claims.add(message.data, time.monotonic())
        except ValueError as error:
            self._node.get_logger().error(str(error), throttle_duration_sec=5.0)

    def claim(self, drives: bool) -> None:
        """Publishes this node's claim."""
        self._publisher.publish(String(data=self._claims.own(drives).encode()))

    def reason(self, drives: bool) -> str:
        """Why this node must not drive; empty if it may. drives: whether it drives already."""
        now = time.monotonic()
        if not drives and now - self._began < SETTLE:
            return "looking for other driving nodes"
        return self._claims.reason(drives, now)
