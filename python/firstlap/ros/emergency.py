"""The emergency stop of a driving node: from any publisher, latched or not, or left by the previous node.

There are two subscriptions, because a latched (transient local) one does not match a volatile publisher such as `ros2
topic pub`, which would print a warning. The latched one is only made if there is a latched publisher. A latched `true`
holds for late subscribers. A latched `false` is ignored: it may be older than the `true` of another publisher, so only
a newly published `false` releases the stop.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy
from std_msgs.msg import Bool

from firstlap.ros.persistent_stop import DRIVING, EMERGENCY, PersistentStop
from firstlap.ros.qos import NEWEST_LATCHED


class EmergencyStop:
    """trip: stops the car; called for each `true`. kept: persists the stop beyond the node's process."""

    def __init__(self, kept: PersistentStop, trip: Callable[[str], object]) -> None:
        self._kept, self._trip = kept, trip
        self._topic = ""
        self._heard: Any = None
        self._heard_latched: Any = None
        self._drives = False
        self.previous = kept.read()
        """EMERGENCY or DRIVING: an event before this node drove, in this or the previous node; else empty."""
        self.pressed = self.previous == EMERGENCY

    def listen(self, node: Any, topic: str) -> None:
        """Subscribes to a topic, which may be empty."""
        self._topic = topic
        if topic:
            self._heard = node.create_subscription(Bool, topic, self.on_message, 1)
            self.check_publishers(node)

    def check_publishers(self, node: Any) -> None:
        """Subscribes to latched messages once there is a latched publisher. Call periodically."""
        if self._heard is None or self._heard_latched is not None:
            return
        publishers = node.get_publishers_info_by_topic(node.resolve_topic_name(self._topic))
        if any(one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in publishers):
            quiet = SubscriptionEventCallbacks(use_default_callbacks=False)  # no warnings about volatile publishers
            self._heard_latched = node.create_subscription(
                Bool, self._topic, self.on_latched, NEWEST_LATCHED, event_callbacks=quiet
            )

    def leave(self, node: Any) -> None:
        """Removes the subscriptions."""
        for one in (self._heard, self._heard_latched):
            if one is not None:
                node.destroy_subscription(one)
        self._heard = self._heard_latched = None

    def on_message(self, message: Any) -> None:
        """True stops the car; false releases the emergency stop."""
        if message.data:
            self.on_latched(message)
        elif self.pressed:
            self.pressed = False
            self._keep()

    def on_latched(self, message: Any) -> None:
        """True stops the car."""
        if not message.data:
            return
        self._trip(EMERGENCY)
        if not self.pressed:
            self.pressed = True
            self.previous = "" if self._drives else EMERGENCY
            self._keep()

    def drives(self, drives: bool) -> None:
        """Records whether the node drives, so that the next node knows if this one dies."""
        self._drives, self.previous = drives, ""
        self._keep()

    def _keep(self) -> None:
        self._kept.keep(EMERGENCY if self.pressed else DRIVING if self._drives else "")

    def consent_reason(self) -> str:
        """Why the parameter `go` is not enough and a person must give consent; empty if it is enough."""
        return {
            EMERGENCY: "an emergency stop was pressed before it drove",
            DRIVING: "the previous node died while it drove",
        }.get(self.previous, "")
