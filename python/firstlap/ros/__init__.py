"""ROS 2 nodes around the core: the driver of a real car, and a simulator that any stack can race on.

Nothing here is imported by the rest of the package. rclpy and the messages come from wheels (`make ros`) or from apt.
"""

from __future__ import annotations

import importlib.util

from firstlap.common.errors import InputError

NEEDED = {
    "rclpy": "firstlap[ros]",
    "ackermann_msgs": "./ros/ackermann_msgs",
    "tf2_msgs": "./ros/tf2_msgs",
}
"""Module -> what to give pip for it."""


def require_ros() -> None:
    """Raises InputError with what to install, where ROS 2 or one of its messages is missing."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        wanted = " ".join(NEEDED[name] for name in missing)
        raise InputError(
            f"ROS 2 is not here (no {', '.join(missing)}): run `make ros` in a checkout (pip install {wanted}), "
            "or source the setup.bash of a ROS 2 from apt"
        )
