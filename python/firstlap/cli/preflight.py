"""firstlap preflight"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from firstlap.cli.common import JsonOption, console, note, print_json
from firstlap.cli.ros_arguments import ros_arguments

if TYPE_CHECKING:
    from firstlap.ros.preflight import Check, Listener

MARKS = {True: "[green]OK[/green]", False: "[red]wrong[/red]", None: "[yellow]not seen[/yellow]"}


def preflight(
    context: typer.Context,
    seconds: Annotated[
        float, typer.Option("--seconds", min=1.0, max=60.0, help="How long to listen to the topics [s].")
    ] = 3.0,
    move: Annotated[
        bool, typer.Option("--move", help="Also check steering, rolling and turning, step by step.")
    ] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before movements (for the simulator).")] = False,
    speed: Annotated[float, typer.Option("--speed", min=0.2, max=1.5, help="Speed of the rolling test [m/s].")] = 0.7,
    as_json: JsonOption = False,
) -> int:
    """Check a car's live topics before it drives. Exit code 1 if something is wrong."""
    from firstlap.ros import require_ros

    require_ros()
    from firstlap.ros.preflight import Check, Listener
    from firstlap.ros.process import ros

    with ros(ros_arguments(context)) as ending:
        listener = Listener()
        try:
            checks = listener.run_checks(seconds)
            if move and all(check.good is not False for check in checks):
                checks += _moving_checks(listener, speed, yes)
            elif move:
                checks.append(Check("moving", None, "fix what is wrong first"))
        finally:
            listener.close()
    if as_json:
        print_json({"checks": [check._asdict() for check in checks]})
    else:
        table = Table("check", "", "result")
        for check in checks:
            table.add_row(check.name, MARKS[check.good], check.said)
        console().print(table)
    return ending.exit_code or int(any(check.good is False for check in checks))


def _moving_checks(listener: Listener, speed: float, yes: bool) -> list[Check]:
    """The guided checks: wheels off the ground first, then the car turned by hand."""
    from firstlap.ros.preflight import Check

    checks: list[Check] = []
    never: Callable[[], bool] = lambda: False  # noqa: E731
    if yes:
        arc: Callable[[Callable[[], bool]], None] = lambda over: listener.command(speed, 0.35, 4.0, over)  # noqa: E731
        return [listener.forward(speed), listener.turned(arc), listener.agrees()]
    if typer.confirm("Put the car on a stand, wheels off the ground. Steer the wheels to the left?"):
        listener.command(0.0, 0.3, 1.5, never)
        good = typer.confirm("Did the front wheels turn to the left?")
        wrong = "change the sign of steering_angle_to_servo_gain"
        checks.append(Check("steer left", good, "confirmed by you" if good else wrong))
    if typer.confirm(f"Wheels still off the ground: roll them forward at {speed:g} m/s for two seconds?"):
        checks.append(listener.forward(speed))
        good = typer.confirm("Did the wheels roll forward?")
        checks.append(
            Check("roll forward", good, "confirmed by you" if good else "change the sign of speed_to_erpm_gain")
        )
    if typer.confirm(
        "Put the car on the ground between walls; you will turn it by hand 90 degrees to the left. Ready?"
    ):
        note("turn it now")
        checks.append(listener.turned(lambda over: listener.listen(15.0, over)))
    ground = "Car on the ground with two meters free ahead: roll it forward to compare its speed with the scans?"
    if typer.confirm(ground):
        checks += [listener.forward(speed), listener.agrees()]
    return checks
