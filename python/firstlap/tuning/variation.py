"""Variation from race to race in the evaluation of a setup: seeds, grip, delays, the car, the start."""

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
        _row("spread", "friction", "", (0.0, 0.5), 0.1, "relative variation of the tire grip"),
        _row("spread", "delay", "s", (0.0, 0.1), 0.02, "variation of steering and speed delay, never below zero"),
        _row("spread", "mass", "", (0.0, 0.5), 0.1, "relative variation of mass and yaw inertia"),
        _row("spread", "servo", "", (0.0, 0.9), 0.2, "relative variation of the servo's time constant"),
        _row("spread", "start_offset", "m", (0.0, 1.0), 0.1, "variation of the start position beside the centerline"),
        _row("spread", "start_yaw", "rad", (0.0, 0.8), 0.1, "variation of the start heading"),
        _row("judge", "laps", "", (2, 100), 2, "laps per race in the search, including the standing-start lap"),
        _row("judge", "margin", "m", (0.0, 1.0), 0.08, "minimum clearance of a reliable setup"),
        _row(
            "judge",
            "hopeless",
            "",
            (0.0, 10.0),
            0.04,
            "candidates slower than the best by more than this share are stopped early",
        ),
        _row(
            "judge",
            "slowest",
            "",
            (1.1, 10.0),
            1.5,
            "a lap slower than this multiple of the starting setup's lap is a timeout",
        ),
        _row("judge", "check_laps", "", (2, 100), 3, "laps per race in the selection"),
        _row(
            "judge",
            "check_seeds",
            "",
            (1, 10_000),
            100,
            "check seeds of the selection; half of the races use the worst limits of the spread",
        ),
        _row("judge", "finalists", "", (1, 100), 2, "reliable setups from which the fastest is selected"),
        _row("judge", "unseen_seeds", "", (1, 10_000), 50, "validation seeds on the tuned track"),
        _row(
            "judge",
            "other_seeds",
            "",
            (0, 10_000),
            2,
            "validation seeds on each other track (0: no other tracks)",
        ),
    ]
)
"""The table of how candidates are evaluated; the option --judge changes a value."""

SPREAD_NAMES = tuple(row.name for row in EVALUATION_FIELDS.fields if row.section == "spread")
WORST = {"friction": -1.0, "delay": 1.0, "servo": 1.0}
"""The limits at which a car is hardest to control, where known."""
BLOCK = 1_000_000_000
PURPOSES = ("search", "choice", "validation")


@dataclass(frozen=True)
class Conditions:
    """The conditions of one race: its seed, and the position within each row of the spread, -1 to 1."""

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
    """The seed of a race; seeds of different purposes, and small seeds (1, 2, 3, ...), never coincide."""
    return BLOCK * (1 + PURPOSES.index(purpose)) + 10_000 * (seed % 100_000) + index


def corners(count: int, seed: int) -> list[Conditions]:
    """Conditions of the search: every row at one of its two limits, each pair of rows in all four combinations equally
    often.

    A two-level orthogonal design (Plackett and Burman 1946), which covers much with few races. The first has the least
    grip and the longest delays, which reveal a hopeless candidate early.
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
    """Conditions of checks: every row uniformly distributed between its limits."""
    result = []
    for k in range(count):
        number = race_seed(purpose, seed, k)
        draw = np.random.default_rng(number).uniform(-1.0, 1.0, len(SPREAD_NAMES))
        result.append(Conditions(number, dict(zip(SPREAD_NAMES, (float(v) for v in draw), strict=True))))
    return result


def checks(count: int, seed: int) -> list[Conditions]:
    """Conditions of the selection: the first half of the races with the least grip and the longest delays.

    A setup that fails there once in twenty races fails elsewhere once in hundreds, which uniformly drawn races would
    rarely reveal.
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
