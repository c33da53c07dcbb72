"""ROS 2 nodes around the core: the driving node, and a simulator for any racing stack.

The rest of the package does not import this module. rclpy and the messages come from wheels (`make ros`) or from apt.
"""

from __future__ import annotations

import importlib.util

from firstlap.common.errors import InputError

NEEDED = {
    "rclpy": "firstlap[ros]",
    "ackermann_msgs": "./ros/ackermann_msgs",
    "tf2_msgs": "./ros/tf2_msgs",
}
"""Module -> pip requirement."""


def require_ros() -> None:
    """Raises InputError with an install instruction if ROS 2 or a message package is missing."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        wanted = " ".join(NEEDED[name] for name in missing)
        raise InputError(
            f"ROS 2 is not available (no {', '.join(missing)}): run `make ros` in a checkout (pip install {wanted}), "
            "or source the setup.bash of a ROS 2 installed by apt"
        )
