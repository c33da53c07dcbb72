"""The simulator node, with the topics of a car."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "track": (str, "arena", "name of a track, a track file, random:SEED, or a ROS map YAML"),
    "car": (str, "", "default, nuc2, gym or a YAML file"),
    "gym_names": (bool, "false", "topics and frames of f1tenth_gym_ros"),
    "factor": (float, "1.0", "real-time factor"),
    "publish_clock": (bool, "false", "publish /clock and use simulated time stamps"),
}


def generate_launch_description() -> LaunchDescription:
    """Launches the simulator node."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (_, default, text) in ARGUMENTS.items()
    ]
    node = Node(
        package="firstlap_ros",
        executable="sim",
        name="firstlap_sim",
        parameters=[
            {
                name: ParameterValue(LaunchConfiguration(name), value_type=kind)
                for name, (kind, _, _) in ARGUMENTS.items()
            }
        ],
        output="screen",
    )
    return LaunchDescription([*declared, node])
