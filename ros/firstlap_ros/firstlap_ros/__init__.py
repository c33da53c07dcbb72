"""The package firstlap under the names that ros2 run and launch look for."""
