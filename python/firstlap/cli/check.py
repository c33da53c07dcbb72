"""firstlap check"""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.table import Table

from firstlap.cli.common import CarOption, JsonOption, SetOption, chosen_setup, console, print_json
from firstlap.config.car_file import load_car
from firstlap.evaluation.setup_limits import check_limits


def check(
    setup: Annotated[str, typer.Argument(metavar="SETUP", help="sure, base, race or a YAML file.")],
    changes: SetOption = None,
    car: CarOption = "default",
    as_json: JsonOption = False,
) -> int:
    """Validate a setup and check it against rules of thumb. Warnings do not change the exit code."""
    chosen = chosen_setup(setup, changes)
    loaded_car = load_car(car)
    rules = check_limits(chosen, loaded_car)
    if as_json:
        print_json({"setup": chosen.name, "car": loaded_car.name, "rules": [asdict(rule) for rule in rules]})
        return 0
    table = Table(title=f"setup {chosen.name} on car {loaded_car.name}", show_lines=True)
    table.add_column("rule", overflow="fold")
    for heading in ("value", "limit", ""):
        table.add_column(heading, justify="right", no_wrap=True)
    for rule in rules:
        verdict = "[green]ok[/]" if rule.holds else "[yellow]warning[/]"
        value = f"{rule.value:.2f} {rule.unit}".rstrip()
        table.add_row(f"{rule.name}: {rule.formula}\n[dim]{rule.remark}[/]", value, rule.wanted, verdict)
    out = console()
    out.print(table)
    broken = sum(not rule.holds for rule in rules)
    out.print("all values are in range; " + (f"{broken} warning{'s' * (broken > 1)}" if broken else "no warnings"))
    return 0
