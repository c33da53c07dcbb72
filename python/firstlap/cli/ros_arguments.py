"""What the commands that run nodes share: arguments for ROS."""

from __future__ import annotations

from typing import Annotated

import typer

from firstlap.errors import InputError

RosArguments = Annotated[
    list[str] | None,
    typer.Argument(metavar="[--ros-args ...]", help="For ROS: -p NAME:=VALUE, -r FROM:=TO, --params-file FILE."),
]
PASS_ON = {"allow_extra_args": True, "ignore_unknown_options": True}


def ros_arguments(context: typer.Context, more: list[str] | None, namespace: str, sim_time: bool) -> list[str]:
    """For rclpy.init. Raises InputError for anything else than --ros-args and what follows it."""
    given = [*(more or []), *context.args]
    if given and given[0] != "--ros-args":
        raise InputError(f"{given[0][:60]}: no such option; what is for ROS follows --ros-args")
    arguments = given or ["--ros-args"]
    if namespace:
        space = namespace.strip("/")
        arguments += ["-r", f"__ns:=/{space}", "-p", f"base_frame:={space}/base_link"]
    if sim_time:
        arguments += ["-p", "use_sim_time:=true"]
    return arguments
