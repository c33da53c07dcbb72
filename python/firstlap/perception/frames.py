"""Frames of /tf_static and /tf: finds the mounting of the LiDAR.

Messages are duck-typed, so that nodes and recordings can use it, with or without ROS 2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.perception.scan import Mount

Matrix = npt.NDArray[np.float64]
MAX_DEPTH = 32
LEVEL = 0.2
"""[rad] Maximum tilt of a planar LiDAR."""


def matrix(transform: Any) -> Matrix:
    """(4, 4) matrix of a geometry_msgs/Transform."""
    q, t = transform.rotation, transform.translation
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def placed(x: float, y: float, yaw: float, roll: float = 0.0) -> Matrix:
    """(4, 4) matrix of a mounting at x, y [m] with roll, then yaw [rad], as in a URDF."""
    c, s, up, aside = math.cos(yaw), math.sin(yaw), math.cos(roll), math.sin(roll)
    return np.array(
        [[c, -s * up, s * aside, x], [s, c * up, -c * aside, y], [0.0, aside, up, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )


class Frames:
    """The tree of the received transforms."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Matrix]] = {}

    def add(self, message: Any) -> None:
        """Adds the transforms of a tf2_msgs/TFMessage."""
        for one in message.transforms:
            self._parents[one.child_frame_id.lstrip("/")] = (one.header.frame_id.lstrip("/"), matrix(one.transform))

    def find(self, base: str, frame: str) -> Matrix | None:
        """(4, 4) pose of `frame` in `base`; None if the tree does not connect them."""
        ups, here = self._up(frame.lstrip("/")), self._up(base.lstrip("/"))
        for name, to_name in ups.items():
            if name in here:
                return np.linalg.inv(here[name]) @ to_name
        return None

    def _up(self, frame: str) -> dict[str, Matrix]:
        """{ancestor: (4, 4) pose of `frame` in it}, beginning with the frame itself."""
        chain, place = {frame: np.eye(4)}, np.eye(4)
        while frame in self._parents and len(chain) < MAX_DEPTH:
            frame, step = self._parents[frame]
            place = step @ place
            chain[frame] = place
        return chain


def mount_of(place: Matrix) -> Mount:
    """The LiDAR's mounting. Raises ValueError if it is not horizontal."""
    up = float(place[2, 2])
    if abs(up) < math.cos(LEVEL):
        raise ValueError(f"the LiDAR is tilted by {math.degrees(math.acos(min(abs(up), 1.0))):.0f} degrees")
    yaw = math.atan2(place[1, 0], place[0, 0])
    return Mount(float(place[0, 3]), float(place[1, 3]), yaw, up < 0.0)
