"""Simulator and driving node: the simulated car drives without consent, as fast as its setup allows."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Includes the other two launch files."""

    def include(name: str, **arguments: object) -> IncludeLaunchDescription:
        path = PathJoinSubstitution([FindPackageShare("firstlap_ros"), "launch", f"{name}.launch.py"])
        return IncludeLaunchDescription(PythonLaunchDescriptionSource(path), launch_arguments=arguments.items())

    return LaunchDescription(
        [
            DeclareLaunchArgument("track", default_value="arena", description="as in sim.launch.py"),
            DeclareLaunchArgument(
                "speed_limit", default_value="20.0", description="[m/s] upper limit of the speed commands"
            ),
            include("sim", track=LaunchConfiguration("track")),
            include("drive", speed_limit=LaunchConfiguration("speed_limit"), go="true"),
        ]
    )
