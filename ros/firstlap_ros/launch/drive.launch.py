"""The driving node on a car. It waits: ros2 lifecycle set /firstlap_drive configure, then activate; or start:=true."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

SURE = PathJoinSubstitution([FindPackageShare("firstlap_ros"), "config", "sure.yaml"])
ARGUMENTS = {
    "params_file": (SURE, "a parameter file; config holds one for each setup"),
    "namespace": ("", "of one car among several"),
    "start": ("false", "drive as soon as scan and odometry are there"),
}
PARAMETERS = {
    "base_frame": (str, "base_link", "middle of the rear axle"),
    "use_sim_time": (bool, "false", "follow /clock"),
    "speed_limit": (float, "20.0", "[m/s] no command is faster"),
}


def generate_launch_description() -> LaunchDescription:
    """One lifecycle node."""
    value = {name: LaunchConfiguration(name) for name in (*ARGUMENTS, *PARAMETERS)}
    given = {name: ParameterValue(value[name], value_type=kind) for name, (kind, _, _) in PARAMETERS.items()}

    def node(start: bool) -> LifecycleNode:
        return LifecycleNode(
            package="firstlap_ros",
            executable="drive",
            name="firstlap_drive",
            namespace=value["namespace"],
            arguments=["--start"] if start else [],
            parameters=[value["params_file"], given],
            condition=(IfCondition if start else UnlessCondition)(value["start"]),
            output="screen",
        )

    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in [*ARGUMENTS.items(), *((name, row[1:]) for name, row in PARAMETERS.items())]
    ]
    return LaunchDescription([*declared, node(True), node(False)])
