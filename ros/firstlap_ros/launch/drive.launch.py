"""The driving node on a car. It waits for consent: `firstlap go`, or the service /firstlap_drive/go."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "params_file": ("", "a parameter file; the folder config has one for each setup"),
    "namespace": ("", "namespace of the car, if there are several"),
}
PARAMETERS = {
    "base_frame": (str, "", "middle of the rear axle"),
    "use_sim_time": (bool, "", "use simulated time (/clock)"),
    "speed_limit": (float, "", "[m/s] upper limit of all speed commands"),
    "go": (bool, "", "consent given in advance: drive as soon as all inputs are valid (for the simulator)"),
    "managed": (bool, "", "a lifecycle manager configures the node"),
    "deadman_topic": (str, "", "dead-man's switch: releasing it stops the car; joy in f1tenth_system"),
    "deadman_button": (int, "", "button index in sensor_msgs/Joy, 5 in f1tenth_system; -1: std_msgs/Bool"),
}
"""Empty: the value of the parameter file, or the node's default."""


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
    """Launches the lifecycle node."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in [*ARGUMENTS.items(), *((name, row[1:]) for name, row in PARAMETERS.items())]
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_node)])
