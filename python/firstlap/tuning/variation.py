"""What differs from race to race while a setup is judged: seeds, grip, delays, the car, the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import hadamard

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable, Value


def _row(section: str, name: str, unit: str, span: tuple[float, float], default: Value, doc: str) -> dict[str, object]:
    kind = "int" if isinstance(default, int) else "float"
    return {
        "section": section,
        "name": name,
        "unit": unit,
        "min": span[0],
        "max": span[1],
        "default": default,
        "doc": doc,
        "type": kind,
    }


EVALUATION_FIELDS = FieldTable(
    [
        _row("spread", "friction", "", (0.0, 0.5), 0.1, "tire grip differs by this share, either way"),
        _row("spread", "delay", "s", (0.0, 0.1), 0.02, "steering and speed delay differ by this, never below zero"),
        _row("spread", "mass", "", (0.0, 0.5), 0.1, "mass and yaw inertia differ by this share"),
        _row("spread", "servo", "", (0.0, 0.9), 0.2, "the servo's time constant differs by this share"),
        _row("spread", "start_offset", "m", (0.0, 1.0), 0.1, "the car starts this far beside the centerline"),
        _row("spread", "start_yaw", "rad", (0.0, 0.8), 0.1, "and turned by this"),
        _row("judge", "laps", "", (2, 100), 2, "laps of a race while searching, the standing one included"),
        _row("judge", "margin", "m", (0.0, 1.0), 0.08, "a setup that comes nearer to a wall does not hold"),
        _row("judge", "hopeless", "", (0.0, 10.0), 0.04, "slower than the best by more than this share: ended early"),
        _row("judge", "slowest", "", (1.1, 10.0), 1.5, "a lap slower than this many of the start's is a timeout"),
        _row("judge", "check_laps", "", (2, 100), 3, "laps of a race when the best are raced again on fresh seeds"),
        _row(
            "judge",
            "check_seeds",
            "",
            (1, 10_000),
            100,
            "fresh seeds on which what is chosen must hold; half of the races at the worst ends",
        ),
        _row("judge", "finalists", "", (1, 100), 2, "setups that hold among which the fastest is chosen"),
        _row("judge", "unseen_seeds", "", (1, 10_000), 50, "seeds of the validation on the track itself"),
        _row(
            "judge",
            "other_seeds",
            "",
            (0, 10_000),
            2,
            "seeds of the validation elsewhere, for each track; 0: not elsewhere",
        ),
    ]
)
"""The one table of how candidates are judged; the option --judge changes a value of it."""

SPREAD_NAMES = tuple(row.name for row in EVALUATION_FIELDS.fields if row.section == "spread")
WORST = {"friction": -1.0, "delay": 1.0, "servo": 1.0}
"""The ends at which a car is hardest to hold, where that is known."""
BLOCK = 1_000_000_000
PURPOSES = ("search", "choice", "validation")


@dataclass(frozen=True)
class Conditions:
    """One race's: its seed, and how far each row of the spread is used, -1 to 1."""

    seed: int
    share: Mapping[str, float]


def evaluation_values(assignments: list[str] | None = None) -> dict[str, float]:
    """{name: value} of the table with the changes of --judge. Raises InputError."""
    values = {row.name: float(row.default) for row in EVALUATION_FIELDS.fields}
    for text in assignments or []:
        row, value = EVALUATION_FIELDS.parse_assignment(text, "--judge", "margin=0.1")
        values[row.name] = float(value)
    return values


def race_seed(purpose: str, seed: int, index: int) -> int:
    """Seeds of different purposes never meet, nor those that people type (1, 2, 3, ...)."""
    return BLOCK * (1 + PURPOSES.index(purpose)) + 10_000 * (seed % 100_000) + index


def corners(count: int, seed: int) -> list[Conditions]:
    """For the search: every row at one of its two ends, each pair of rows in all four ways equally often.

    A two-level orthogonal design (Plackett and Burman 1946), so that few races meet much. The first has the least grip
    and the longest delays, because a hopeless candidate shows itself there.
    """
    size = 8
    while size < min(count, 1024):
        size *= 2
    design = hadamard(size)[:, 1 : 1 + len(SPREAD_NAMES)]
    worst = np.array([WORST.get(name, 1.0) for name in SPREAD_NAMES])
    return [
        Conditions(
            race_seed("search", seed, k),
            dict(zip(SPREAD_NAMES, (float(v) for v in design[k % size] * worst), strict=True)),
        )
        for k in range(count)
    ]


def drawn(count: int, seed: int, purpose: str) -> list[Conditions]:
    """For checks: every row anywhere between its ends, evenly."""
    result = []
    for k in range(count):
        number = race_seed(purpose, seed, k)
        draw = np.random.default_rng(number).uniform(-1.0, 1.0, len(SPREAD_NAMES))
        result.append(Conditions(number, dict(zip(SPREAD_NAMES, (float(v) for v in draw), strict=True))))
    return result


def checks(count: int, seed: int) -> list[Conditions]:
    """For the choice: half of the races, which come first, with the least grip and the longest delays there are.

    What fails there once in twenty races fails elsewhere once in hundreds, so that races drawn evenly would not show
    it and one on the track would.
    """
    found = drawn(count, seed, "choice")
    hard = (count + 1) // 2
    return [replace(one, share={**one.share, **WORST}) for one in found[:hard]] + found[hard:]


def changed_car(car: Car, spread: Mapping[str, float], conditions: Conditions) -> Car:
    """The car under these conditions."""
    core: Any = _core.Car(car.core)
    by = {name: float(conditions.share[name] * spread[name]) for name in SPREAD_NAMES}
    for name, factor in (
        ("friction", 1.0 + by["friction"]),
        ("mass", 1.0 + by["mass"]),
        ("yaw_inertia", 1.0 + by["mass"]),
        ("servo_time_constant", 1.0 + by["servo"]),
    ):
        core.set("vehicle", name, core.get("vehicle", name) * factor)
    for name in ("steering_delay", "speed_delay"):
        core.set("vehicle", name, max(core.get("vehicle", name) + by["delay"], 0.0))
    return Car(car.name, core, car.source)


def race_options(spread: Mapping[str, float], conditions: Conditions) -> dict[str, float]:
    """The start under these conditions, as race options."""
    return {name: conditions.share[name] * spread[name] for name in ("start_offset", "start_yaw")}
