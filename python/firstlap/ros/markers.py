"""Walls, path and lookahead of the last step for rviz and Foxglove."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker, MarkerArray

from firstlap.recordings.log_messages import COLORS, SEEN_SIZE
from firstlap.ros.conversions import set_stamp
from firstlap.ros.node_parameters import value_of

PATH_COLOR = (0.17, 0.63, 0.17, 1.0)
AIM_COLOR = (0.84, 0.15, 0.16, 1.0)


class Markers:
    """Publishes on ~/markers at `marker_rate`, only while there are subscribers."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publisher = node.create_publisher(MarkerArray, "~/markers", 1)
        self._last = float("-inf")

    def publish(self, handle: Any, stamp: float) -> None:
        """Publishes the trace of the last step. stamp: of its scan [s]."""
        rate = value_of(self._node, "marker_rate")
        due = 0.0 <= stamp - self._last < 1.0 / rate if rate > 0.0 else True
        if due or self._publisher.get_subscription_count() == 0:
            return
        self._last = stamp
        trace = handle.trace
        if "path" not in trace:
            return
        base = value_of(self._node, "base_frame")
        aim = trace["lookahead"]
        path = np.column_stack([trace["path"]["x"], trace["path"]["y"]])
        shapes = [
            ("left", Marker.SPHERE_LIST, trace["left"]["points"], COLORS["left"], SEEN_SIZE),
            ("right", Marker.SPHERE_LIST, trace["right"]["points"], COLORS["right"], SEEN_SIZE),
            ("path", Marker.LINE_STRIP, path, PATH_COLOR, 0.03),
            ("lookahead", Marker.SPHERE_LIST, np.array([[aim["x"], aim["y"]]]), AIM_COLOR, 0.12),
        ]
        self._publisher.publish(MarkerArray(markers=[_marker(base, stamp, *shape) for shape in shapes]))


def _marker(frame: str, stamp: float, name: str, kind: int, points: Any, color: Any, size: float) -> Any:
    enough = len(points) >= (2 if kind == Marker.LINE_STRIP else 1)
    marker = Marker(ns=name, type=kind, action=Marker.ADD if enough else Marker.DELETE)
    marker.header.frame_id = frame
    set_stamp(marker.header.stamp, stamp)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = color
    marker.points = [Point(x=float(x), y=float(y), z=0.0) for x, y in points]
    return marker
