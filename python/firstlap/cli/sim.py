"""firstlap sim"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from firstlap.cli.common import JsonOption, ReverseOption, SeedOption, note, print_json
from firstlap.cli.ros_arguments import ros_arguments

TrackArgument = Annotated[
    str,
    typer.Argument(metavar="TRACK", help="Name of a track, a track file, random:SEED, or a ROS map YAML."),
]
LidarOption = Annotated[str, typer.Option("--lidar", metavar="LIDAR", help="rplidar_a2, ld19, ... or a YAML file.")]
CarOption = Annotated[str, typer.Option("--car", metavar="CAR", help="default, nuc2, gym or a YAML file.")]
CarsOption = Annotated[
    int, typer.Option("--cars", min=1, max=16, help="Number of cars on the track, each in its own namespace.")
]
FactorOption = Annotated[float, typer.Option("--factor", help="Real-time factor; publishes /clock.")]
ClockOption = Annotated[bool, typer.Option("--clock", help="Publish /clock and use simulated time stamps.")]
GymOption = Annotated[bool, typer.Option("--gym-names", help="Use the topics and frames of f1tenth_gym_ros.")]
LapsOption = Annotated[int | None, typer.Option("--laps", min=1, help="End when every car has driven this many laps.")]


def sim(
    context: typer.Context,
    track: TrackArgument = "arena",
    lidar: LidarOption = "",
    car: CarOption = "",
    cars: CarsOption = 1,
    seed: SeedOption = 1,
    reverse: ReverseOption = False,
    factor: FactorOption = 1.0,
    clock: ClockOption = False,
    gym: GymOption = False,
    laps: LapsOption = None,
    as_json: JsonOption = False,
) -> int:
    """Simulate cars over ROS 2 in real time: publishes scan, odometry and TF, subscribes to drive. Arguments after
    --ros-args go to ROS."""
    from firstlap.ros import require_ros

    arguments = ros_arguments(context)
    require_ros()

    from firstlap.ros.process import ros, run_sim
    from firstlap.ros.sim_node import SimNode

    given: dict[str, Any] = {
        "track": track,
        "car": car,
        "lidar": lidar,
        "seed": seed,
        "reverse": reverse,
        "factor": factor,
        "publish_clock": clock or factor != 1.0,
        "gym_names": gym,
        "world.cars": cars,
    }
    if gym:
        given["world.command_timeout"] = 0.0
    with ros(arguments) as ending:
        node = SimNode(given, report=note)
        run_sim(node, ending, lambda: laps is not None and all(node.world.laps_done(i) >= laps for i in range(cars)))
        summary = node.summary()
    if as_json:
        print_json(summary)
    done = laps is None or all(len(car["laps"]) >= laps for car in summary["cars"])
    return ending.exit_code or (0 if done and not any(car["contacts"] for car in summary["cars"]) else 1)
