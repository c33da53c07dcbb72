"""The emergency stop as a driving node hears it: from any publisher, latched or not, and from the node before it.

Two subscriptions, for one that asks for the latched message is not matched with a publisher that latches none, and that
one (`ros2 topic pub`) is warned of it: the second is made only where somebody latches. A latched `true` holds for
whoever comes later. A latched `false` says nothing: it may be older than the `true` of somebody else, so only one that
is said now takes the ban away.
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
    """trip: stops the car; called with every word that says so. kept: what outlives the node's process."""

    def __init__(self, kept: PersistentStop, trip: Callable[[str], object]) -> None:
        self._kept, self._trip = kept, trip
        self._topic = ""
        self._heard: Any = None
        self._heard_latched: Any = None
        self._drives = False
        self.left = kept.read()
        """EMERGENCY or DRIVING: what came to pass before this node drove, with it or with the one before."""
        self.pressed = self.left == EMERGENCY

    def listen(self, node: Any, topic: str) -> None:
        """On a topic, which may be empty."""
        self._topic = topic
        if topic:
            self._heard = node.create_subscription(Bool, topic, self.on_word, 1)
            self.look(node)

    def look(self, node: Any) -> None:
        """Call often: whether somebody latches it."""
        if self._heard is None or self._heard_latched is not None:
            return
        said = node.get_publishers_info_by_topic(node.resolve_topic_name(self._topic))
        if any(one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in said):
            quiet = SubscriptionEventCallbacks(use_default_callbacks=False)  # of those that do not
            self._heard_latched = node.create_subscription(
                Bool, self._topic, self.on_latched, NEWEST_LATCHED, event_callbacks=quiet
            )

    def leave(self, node: Any) -> None:
        """Listens no more."""
        for one in (self._heard, self._heard_latched):
            if one is not None:
                node.destroy_subscription(one)
        self._heard = self._heard_latched = None

    def on_word(self, message: Any) -> None:
        """True stops; false only takes the ban away."""
        if message.data:
            self.on_latched(message)
        elif self.pressed:
            self.pressed = False
            self._keep()

    def on_latched(self, message: Any) -> None:
        """True stops."""
        if not message.data:
            return
        self._trip(EMERGENCY)
        if not self.pressed:
            self.pressed = True
            self.left = "" if self._drives else EMERGENCY
            self._keep()

    def drives(self, drives: bool) -> None:
        """Whether the node drives from now on: one that dies meanwhile is told of to the next."""
        self._drives, self.left = drives, ""
        self._keep()

    def _keep(self) -> None:
        self._kept.keep(EMERGENCY if self.pressed else DRIVING if self._drives else "")

    def why_wait(self) -> str:
        """Why the node's own `go` is not enough, and a person must speak; empty where it is."""
        return {
            EMERGENCY: "an emergency stop was pressed before it drove",
            DRIVING: "the node before this one died while it drove",
        }.get(self.left, "")
