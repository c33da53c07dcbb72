"""firstlap go, resume, stop, set: one request to a driving node. Exit code 3 if no such node answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from firstlap.cli.common import fail
from firstlap.cli.ros_arguments import ros_arguments

if TYPE_CHECKING:
    from firstlap.ros.remote import Remote

NO_NODE = 3
NamespaceOption = Annotated[
    str, typer.Option("--namespace", metavar="NAME", help="Namespace of the car, if there are several.")
]
WaitOption = Annotated[
    float, typer.Option("--wait", min=0.1, max=60.0, help="Timeout for finding the driving node [s].")
]
ReleaseOption = Annotated[bool, typer.Option("--release", help="Release an emergency stop first.")]
WAIT = 5.0


def go(
    context: typer.Context, namespace: NamespaceOption = "", release: ReleaseOption = False, wait: WaitOption = WAIT
) -> int:
    """Give consent: let a waiting or stopped node drive."""
    return _request(context, namespace, wait, lambda node: _done(node.consent("go", release)))


def resume(
    context: typer.Context, namespace: NamespaceOption = "", release: ReleaseOption = False, wait: WaitOption = WAIT
) -> int:
    """Let a stopped node continue; not one that was just started."""
    return _request(context, namespace, wait, lambda node: _done(node.consent("resume", release)))


def stop(
    context: typer.Context,
    namespace: NamespaceOption = "",
    emergency: Annotated[
        bool, typer.Option("--emergency", help="Press the emergency stop: consent is refused until it is released.")
    ] = False,
    wait: WaitOption = WAIT,
) -> int:
    """Stop the car until a person gives consent."""

    def ask(node: Remote) -> int:
        if not emergency:
            return _done(node.trigger("stop"))
        node.emergency_stop(True)
        return _done((True, "emergency stop; `firstlap go --release` releases it"))

    return _request(context, namespace, wait, ask)


def set_parameter(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="Name of the parameter, such as speed_limit, velocity_profile.v_max or v_max."
        ),
    ],
    value: Annotated[str, typer.Argument(metavar="VALUE", help="New value.")],
    namespace: NamespaceOption = "",
    wait: WaitOption = WAIT,
) -> int:
    """Change a parameter of a driving node while it drives."""

    def ask(node: Remote) -> int:
        full, before, after = node.set(name, value)
        return _done((True, f"{full}: {after}, was {before}"))

    return _request(context, namespace, wait, ask)


def _done(answer: tuple[bool, str]) -> int:
    done, text = answer
    if not done:
        return fail(text, 1)
    print(text)
    return 0


def _request(context: typer.Context, namespace: str, wait: float, ask: Callable[[Remote], int]) -> int:
    from firstlap.ros import require_ros

    arguments = ros_arguments(context, namespace)
    require_ros()
    from firstlap.ros.process import ros
    from firstlap.ros.remote import NoNodeError, remote

    with ros(arguments) as ending, remote(wait) as node:
        try:
            code = ask(node)
        except NoNodeError as error:
            code = fail(str(error), NO_NODE)
    return ending.exit_code or code
