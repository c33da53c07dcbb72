"""Other driving nodes on the drive topic of this one: heard and told by claims on `<drive topic>/claim`."""

from __future__ import annotations

import os
import socket
import time
from typing import Any

from std_msgs.msg import String

from firstlap.ros.claims import SETTLE, Claims
from firstlap.ros.qos import NEWEST_LATCHED


class OtherDrivers:
    """Of a driving node that commands on `topic`."""

    def __init__(self, node: Any, topic: str) -> None:
        who = f"{node.get_fully_qualified_name()}, process {os.getpid()} on {socket.gethostname()}"
        self._claims = Claims(time.time_ns(), who)
        self._began = time.monotonic()
        self._node = node
        self._publisher = node.create_publisher(String, f"{topic}/claim", NEWEST_LATCHED)
        node.create_subscription(String, f"{topic}/claim", self.on_claim, 10)

    def on_claim(self, message: Any) -> None:
        """Somebody's, perhaps our own."""
        try:
            self._claims.hear(message.data, time.monotonic())
        except ValueError as error:
            self._node.get_logger().error(str(error), throttle_duration_sec=5.0)

    def claim(self, drives: bool) -> None:
        """Tells the others how it stands here."""
        self._publisher.publish(String(data=self._claims.own(drives).encode()))

    def reason(self, drives: bool) -> str:
        """Why this node must not drive; empty where it may. drives: whether it does already."""
        now = time.monotonic()
        if not drives and now - self._began < SETTLE:
            return "looking for other driving nodes"
        return self._claims.reason(drives, now)
