"""What a log of ours says of itself, so that it can be replayed as it was driven."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from firstlap import __version__ as version
from firstlap import _core
from firstlap.car_file import CAR_FIELDS, Car
from firstlap.errors import InputError
from firstlap.parameters import FieldTable, Values
from firstlap.setup_file import SETUP_FIELDS, Setup

RECORD = "firstlap"
"""Name of the MCAP metadata record."""


@dataclass(frozen=True)
class About:
    """setup and car as they were driven; scan_period [s] where scans came by a clock; what, for people."""

    setup: Setup
    car: Car
    scan_period: float | None = None
    what: str = ""
    seed: int | None = None
    version: str = version

    def to_metadata(self) -> dict[str, str]:
        """Texts, as MCAP wants them; numbers with all their digits."""
        return {
            "version": self.version,
            "what": self.what,
            "setup": json.dumps({"name": self.setup.name, "values": _nested(self.setup.given)}),
            "car": json.dumps({"name": self.car.name, "values": self.car.core.values()}),
            "scan_period": json.dumps(self.scan_period),
            "seed": json.dumps(self.seed),
        }

    @classmethod
    def from_metadata(cls, texts: Mapping[str, str], where: str) -> About:
        """The other way round. Raises InputError where the record was not written by us."""
        try:
            setup, car = json.loads(texts["setup"]), json.loads(texts["car"])
            period, seed = json.loads(texts.get("scan_period", "null")), json.loads(texts.get("seed", "null"))
            core = _core.Car.preset("default")
            for (section, name), value in _checked(CAR_FIELDS, car["values"], where).items():
                core.set(section, name, value)
            core.validate()
            given = _checked(SETUP_FIELDS, setup["values"], where)
            loaded = Setup(str(setup["name"]), given, where)
            loaded.validate(where)
            return cls(
                setup=loaded,
                car=Car(str(car["name"]), core, where),
                scan_period=None if period is None else float(period),
                what=str(texts.get("what", "")),
                seed=None if seed is None else int(seed),
                version=str(texts.get("version", "")),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            why = f"{type(error).__name__}: {error}"
            raise InputError(f"{where}: its record '{RECORD}' cannot be read ({why})") from None


def _nested(values: Values) -> dict[str, dict[str, Any]]:
    nested: dict[str, dict[str, Any]] = {}
    for (section, name), value in values.items():
        nested.setdefault(section, {})[name] = value
    return nested


def _checked(table: FieldTable, sections: Mapping[str, Mapping[str, Any]], where: str) -> Values:
    """Values within their ranges; raises for what the table does not know."""
    checked: Values = {}
    for section, values in sections.items():
        for name, value in values.items():
            field = table.find(f"{section}.{name}", where)
            checked[section, field.name] = table.check(field, float(value), where)
    return checked
