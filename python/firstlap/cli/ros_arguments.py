"""ROS arguments of the commands that run nodes."""

from __future__ import annotations

import re

import typer
from typer.core import TyperCommand

from firstlap.common.errors import InputError

MARK = "--ros-args"
NAMESPACE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*", re.ASCII)


class RosCommand(TyperCommand):
    """A command that passes --ros-args and everything after it to ROS."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:  # type: ignore[override]
        """Removes the ROS arguments before the others are parsed."""
        at = args.index(MARK) if MARK in args else len(args)
        ctx.meta[MARK] = args[at:]
        return super().parse_args(ctx, args[:at])


def ros_arguments(context: typer.Context, namespace: str = "", sim_time: bool = False) -> list[str]:
    """The arguments of rclpy.init. Raises InputError."""
    arguments = list(context.meta.get(MARK) or [MARK])
    if namespace:
        space = namespace.strip("/")
        if not NAMESPACE.fullmatch(space):
            raise InputError(f"--namespace: '{namespace[:60]}': expected letters, digits and '_', such as car1")
        arguments += ["-r", f"__ns:=/{space}", "-p", f"base_frame:={space}/base_link"]
    if sim_time:
        arguments += ["-p", "use_sim_time:=true"]
    return arguments
