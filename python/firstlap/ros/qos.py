"""QoS profiles."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors: the newest message only, from any publisher."""
RECENT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Topics of a trace: those of one step may arrive at different times."""
LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""/tf_static"""
NEWEST_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""State for late subscribers: the emergency stop, a map, a claim."""
