"""How topics are heard."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors: the newest message only, from any publisher."""
RECENT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""The topics of a trace: one of them may be heard later than the others of its step."""
LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""/tf_static"""
NEWEST_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""What is said once and still holds for whoever comes later: the emergency stop, a map, a claim."""
