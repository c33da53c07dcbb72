"""Scans, their checks, and the LiDAR's mounting."""
