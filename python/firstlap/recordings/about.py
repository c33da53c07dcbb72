"""The metadata of our own logs, with which they can be replayed exactly."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.text import printable
from firstlap.common.version import __version__
from firstlap.config.car_file import CAR_FIELDS, Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import FieldTable, Values
from firstlap.config.setup_file import Setup

RECORD = "firstlap"
"""Name of the MCAP metadata record."""


@dataclass(frozen=True)
class About:
    """setup and car of the drive; what: its description.

    Messages have a resolution of nanoseconds and angles in single precision, so the exact values passed to the planner
    are stored here: header (angle_min, angle_increment, time_increment, range_min, range_max) and scan_period [s], if
    constant, and first_dt [s], the dt of the first scan.
    """

    setup: Setup
    car: Car
    what: str = ""
    header: tuple[float, ...] | None = None
    scan_period: float | None = None
    first_dt: float | None = None
    seed: int | None = None
    version: str = __version__

    def to_metadata(self) -> dict[str, str]:
        """As strings, for MCAP; numbers with all digits."""
        return {
            "version": self.version,
            "what": printable(self.what),
            "setup": json.dumps(
                {"name": self.setup.name, "driver": self.setup.driver, "values": _nested(self.setup.given)}
            ),
            "car": json.dumps({"name": self.car.name, "values": self.car.core.values()}),
            "exact": json.dumps(
                {"header": self.header, "scan_period": self.scan_period, "first_dt": self.first_dt, "seed": self.seed}
            ),
        }

    @classmethod
    def from_metadata(cls, texts: Mapping[str, str], where: str) -> About:
        """The inverse of `to_metadata`. Raises InputError if the record was not written by firstlap."""
        try:
            setup, car = json.loads(texts["setup"]), json.loads(texts["car"])
            exact = json.loads(texts["exact"])
            header = exact["header"]
            core = _core.Car.preset("default")
            for (section, name), value in _checked(CAR_FIELDS, car["values"], where).items():
                core.set(section, name, value)
            core.validate()
            kind = driver_kind(setup["driver"], f"{where}: driver")
            given = _checked(kind.fields, setup["values"], where)
            loaded = Setup(str(setup["name"]), given, where, driver=kind.name)
            loaded.validate(where)
            return cls(
                setup=loaded,
                car=Car(str(car["name"]), core, where),
                what=str(texts.get("what", "")),
                header=None if header is None else tuple(float(number) for number in header),
                scan_period=_number(exact["scan_period"]),
                first_dt=_number(exact["first_dt"]),
                seed=None if exact["seed"] is None else int(exact["seed"]),
                version=str(texts.get("version", "")),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InputError(f"{where}: its record '{RECORD}' cannot be read ({error})") from None


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


def _nested(values: Values) -> dict[str, dict[str, Any]]:
    nested: dict[str, dict[str, Any]] = {}
    for (section, name), value in values.items():
        nested.setdefault(section, {})[name] = value
    return nested


def _checked(table: FieldTable, sections: Mapping[str, Mapping[str, Any]], where: str) -> Values:
    """Checks names and ranges of values. Raises InputError."""
    checked: Values = {}
    for section, values in sections.items():
        for name, value in values.items():
            field = table.find(f"{section}.{name}", where)
            checked[section, field.name] = table.check(field, float(value), where)
    return checked
