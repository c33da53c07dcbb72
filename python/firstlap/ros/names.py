"""Parameters of the nodes, except the drivers' parameters: topics, frames, limits, faults.

One row per parameter, the single source of its default. Topics are relative to the namespace.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """One ROS parameter. min, max: range of a number. fixed: read-only once the node runs."""

    name: str
    default: str | float | int | bool
    doc: str
    min: float | None = None
    max: float | None = None
    fixed: bool = False


DRIVE = (
    Entry("driver", "", "local, gap, disparity, ...; empty: the setup's driver", fixed=True),
    Entry("setup", "", "name of a setup, or a YAML file; empty: the driver's default", fixed=True),
    Entry("scan_topic", "scan", "sensor_msgs/LaserScan", fixed=True),
    Entry("odom_topic", "odom", "nav_msgs/Odometry; the twist is used", fixed=True),
    Entry("imu_topic", "", "sensor_msgs/Imu, whose yaw rate replaces the odometry's; empty: none", fixed=True),
    Entry("steering_topic", "", "sensor_msgs/JointState with the measured steering angle; empty: none", fixed=True),
    Entry("steering_joint", "steering", "joint name in steering_topic", fixed=True),
    Entry("drive_topic", "drive", "ackermann_msgs/AckermannDriveStamped", fixed=True),
    Entry("emergency_stop_topic", "emergency_stop", "std_msgs/Bool, latched or not; true stops the car", fixed=True),
    Entry(
        "deadman_topic",
        "",
        "dead-man's switch: released stops the car, a new press is consent; empty: none",
        fixed=True,
    ),
    Entry(
        "deadman_button",
        -1,
        "button index in sensor_msgs/Joy, 5 in f1tenth_system; -1: deadman_topic is a std_msgs/Bool",
        -1,
        63,
        True,
    ),
    Entry(
        "go", False, "consent given in advance: drive as soon as all inputs are valid (for the simulator)", fixed=True
    ),
    Entry("managed", False, "a lifecycle manager configures the node; false: the node configures itself", fixed=True),
    Entry("base_frame", "base_link", "middle of the rear axle", fixed=True),
    Entry("laser_from_tf", True, "LiDAR mounting from TF; false: from car.laser_x, car.laser_y and laser_yaw"),
    Entry("laser_yaw", 0.0, "[rad] mounting yaw of the LiDAR if laser_from_tf is false", -3.2, 3.2),
    Entry("check_odometry", True, "odometry that contradicts scans, poses or commands stops the car", fixed=True),
    Entry("speed_limit", 1.5, "[m/s] upper limit of all speed commands", 0.0, 20.0),
    Entry(
        "scan_timeout", 0.0, "[s] without a valid scan until the car stops; 0: 2.5 scan periods, 0.1 to 0.5 s", 0.0, 1.0
    ),
    Entry(
        "odom_timeout",
        0.0,
        "[s] without valid odometry, IMU or steering angle until the car stops; 0: 2.5 periods, 0.2 to 0.3 s",
        0.0,
        1.0,
    ),
    Entry("deadman_timeout", 0.2, "[s] without a message on deadman_topic until the car stops", 0.02, 2.0),
    Entry("pause_limit", 0.2, "[s] in which the node did not run, after which the car stops", 0.05, 1.0),
    Entry("max_age", 0.15, "[s] maximum age of messages, in addition to a scan's sweep time (0: any age)", 0.0, 5.0),
    Entry(
        "marker_rate",
        10.0,
        "[Hz] rate of the markers (walls, path, lookahead) for rviz and Foxglove; 0: none",
        0.0,
        100.0,
    ),
    Entry("trace_rate", 20.0, "[Hz] rate of the topics under ~/trace while someone subscribes; 0: none", 0.0, 100.0),
)

IDENTITY = (
    Entry("driving_driver", "", "the current driver (read-only; choose it with `driver`)", fixed=True),
    Entry("driving_setup", "", "the loaded setup (read-only; choose it with `setup`)", fixed=True),
)

SIM = (
    Entry("track", "arena", "name of a track, a track file, random:SEED, or a ROS map YAML", fixed=True),
    Entry("car", "", "default, nuc2, gym or a YAML file; empty: default, with gym_names gym", fixed=True),
    Entry("lidar", "", "rplidar_a2, ld19, ... or a YAML file; empty: the car's LiDAR", fixed=True),
    Entry("reverse", False, "drive in the opposite direction", fixed=True),
    Entry("seed", 1, "seed of all noise", 0, 2**31 - 1, fixed=True),
    Entry(
        "factor",
        1.0,
        "real-time factor; values other than 1 need publish_clock, and use_sim_time in other nodes",
        0.2,
        20.0,
        True,
    ),
    Entry("publish_clock", False, "publish /clock and use simulated time stamps", fixed=True),
    Entry("ground_truth", True, "publish ground_truth/odom, in the frame map"),
    Entry("gym_names", False, "topics and frames of f1tenth_gym_ros", fixed=True),
    Entry(
        "namespaces",
        "",
        "comma-separated namespaces of the cars; empty: none for one car, else car1, car2, ...",
        fixed=True,
    ),
    Entry("kick_lateral_speed", 0.5, "[m/s] lateral speed of the service kick", -5.0, 5.0),
    Entry("kick_yaw_rate", 1.5, "[rad/s] yaw rate of the service kick", -20.0, 20.0),
)

FAULTS = (
    Entry("drop_scans", 0.0, "share of scans that are not published", 0.0, 1.0),
    Entry("drop_odometry", 0.0, "share of odometry that is not published", 0.0, 1.0),
    Entry("freeze_odometry", False, "repeat the same odometry"),
    Entry("delay", 0.0, "[s] delay of scans", 0.0, 1.0),
    Entry("stamp_offset", 0.0, "[s] added to the stamps of scans and odometry", -100.0, 100.0),
    Entry("backward_stamps", False, "every stamp is older than the previous one"),
    Entry("nan_scans", False, "all ranges are NaN"),
    Entry("nan_odometry", False, "speed and yaw rate are NaN"),
    Entry(
        "odometry_speed_scale", 1.0, "scale of the speed in the twist: -1 negated, 3.6 km/h, 0 stuck at 0", -10.0, 10.0
    ),
    Entry("odometry_yaw_rate_scale", 1.0, "scale of the yaw rate in the twist: -1 negated, 57.3 deg/s", -100.0, 100.0),
    Entry("odometry_in_map", False, "the twist is in the map frame, not in the car's frame"),
    Entry("drop_imu", 0.0, "share of IMU messages that are not published", 0.0, 1.0),
    Entry("nan_imu", False, "the IMU's yaw rate is NaN"),
    Entry("drop_steering", 0.0, "share of measured steering angles that are not published", 0.0, 1.0),
    Entry("scan_beams", 0, "number of beams published; 0: all", 0, 10000),
    Entry("end_stamps", False, "scans are stamped at their last beam instead of the first"),
    Entry("scan_frame", "", "frame of the scans; empty: the correct one"),
)
