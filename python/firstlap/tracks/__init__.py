"""Tracks: our own files, ROS maps, centerlines and random tracks, all as a `Track`."""
