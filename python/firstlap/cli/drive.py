"""firstlap drive"""

from __future__ import annotations

from typing import Annotated

import typer

from firstlap.cli.common import DriverOption, SetOption, SetupOption, chosen_setup
from firstlap.cli.ros_arguments import ros_arguments


def drive(
    context: typer.Context,
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    namespace: Annotated[
        str, typer.Option("--namespace", metavar="NAME", help="Namespace of the car, if there are several.")
    ] = "",
    go: Annotated[
        bool,
        typer.Option(
            "--go", help="Give consent in advance: drive as soon as all inputs are valid (for the simulator)."
        ),
    ] = False,
    sim_time: Annotated[bool, typer.Option("--sim-time", help="Use simulated time (/clock).")] = False,
) -> int:
    """Drive a real or simulated car over ROS 2, as a lifecycle node that waits for `firstlap go`. Arguments after
    --ros-args go to ROS."""
    from firstlap.ros import require_ros

    arguments = ros_arguments(context, namespace, sim_time) + (["-p", "go:=true"] if go else [])
    require_ros()
    given = chosen_setup(setup, changes, driver)

    from firstlap.drivers.driving import Driving
    from firstlap.ros.drive_node import DriveNode
    from firstlap.ros.process import ros, run_drive

    with ros(arguments) as ending:
        node = DriveNode(Driving(given))
        run_drive(node, ending)
    return ending.exit_code
