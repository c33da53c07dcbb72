"""Tracks: our own files, ROS maps and random ones, all as one `Track`."""
