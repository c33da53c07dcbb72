"""Entry points of the package firstlap for ros2 run and ros2 launch."""
