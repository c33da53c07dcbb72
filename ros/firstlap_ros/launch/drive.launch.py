"""The driving node on a car. It waits for a person: `firstlap go`, or the service /firstlap_drive/go."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "params_file": ("", "a parameter file; config holds one for each setup"),
    "namespace": ("", "of one car among several"),
}
PARAMETERS = {
    "base_frame": (str, "", "middle of the rear axle"),
    "use_sim_time": (bool, "", "follow /clock"),
    "speed_limit": (float, "", "[m/s] no command is faster"),
    "go": (bool, "", "drive as soon as all is there, without a person's consent: for the simulator"),
    "managed": (bool, "", "a lifecycle manager configures the node"),
    "deadman_topic": (str, "", "held, or the car stops; joy in f1tenth_system"),
    "deadman_button": (int, "", "of sensor_msgs/Joy, 5 in f1tenth_system; -1: std_msgs/Bool"),
}
"""Empty: as the parameter file says, or the node itself."""


def _node(context: LaunchContext) -> list[LifecycleNode]:
    given = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (kind, _, _) in PARAMETERS.items()
        if LaunchConfiguration(name).perform(context)
    }
    file = LaunchConfiguration("params_file").perform(context)
    node = LifecycleNode(
        package="firstlap_ros",
        executable="drive",
        name="firstlap_drive",
        namespace=LaunchConfiguration("namespace"),
        parameters=[*([file] if file else []), given],
        output="screen",
    )
    return [node]


def generate_launch_description() -> LaunchDescription:
    """One lifecycle node."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in [*ARGUMENTS.items(), *((name, row[1:]) for name, row in PARAMETERS.items())]
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_node)])
