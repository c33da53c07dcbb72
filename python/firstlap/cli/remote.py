"""firstlap go, resume, stop, set: one request to a driving node. Exit code 3 where no such node answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from firstlap.cli.common import fail
from firstlap.cli.ros_arguments import ros_arguments

if TYPE_CHECKING:
    from firstlap.ros.remote import Remote

NO_NODE = 3
NamespaceOption = Annotated[str, typer.Option("--namespace", metavar="NAME", help="Of one car among several.")]
WaitOption = Annotated[float, typer.Option("--wait", min=0.1, max=60.0, help="[s] to look for the driving node.")]
ReleaseOption = Annotated[bool, typer.Option("--release", help="First take an emergency stop away.")]
WAIT = 5.0


def go(
    context: typer.Context, namespace: NamespaceOption = "", release: ReleaseOption = False, wait: WaitOption = WAIT
) -> int:
    """Let a driving node drive, one that waits since it was started or one that was stopped: a person's consent."""
    return _asked(context, namespace, wait, lambda node: _done(node.consent("go", release)))


def resume(
    context: typer.Context, namespace: NamespaceOption = "", release: ReleaseOption = False, wait: WaitOption = WAIT
) -> int:
    """Let a driving node that was stopped drive on; not one that was started anew."""
    return _asked(context, namespace, wait, lambda node: _done(node.consent("resume", release)))


def stop(
    context: typer.Context,
    namespace: NamespaceOption = "",
    emergency: Annotated[
        bool, typer.Option("--emergency", help="Press the emergency stop: until it is released, nobody can let it go.")
    ] = False,
    wait: WaitOption = WAIT,
) -> int:
    """Stop a car until a person lets it go on."""

    def ask(node: Remote) -> int:
        if not emergency:
            return _done(node.trigger("stop"))
        node.emergency_stop(True)
        return _done((True, "emergency stop; `firstlap go --release` takes it away"))

    return _asked(context, namespace, wait, ask)


def set_parameter(
    context: typer.Context,
    name: Annotated[str, typer.Argument(metavar="NAME", help="Such as speed_limit, velocity_profile.v_max or v_max.")],
    value: Annotated[str, typer.Argument(metavar="VALUE", help="Its new value.")],
    namespace: NamespaceOption = "",
    wait: WaitOption = WAIT,
) -> int:
    """Change a parameter of a driving node, while it drives."""

    def ask(node: Remote) -> int:
        full, before, after = node.set(name, value)
        return _done((True, f"{full}: {after}, was {before}"))

    return _asked(context, namespace, wait, ask)


def _done(answer: tuple[bool, str]) -> int:
    done, said = answer
    if not done:
        return fail(said, 1)
    print(said)
    return 0


def _asked(context: typer.Context, namespace: str, wait: float, ask: Callable[[Remote], int]) -> int:
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
