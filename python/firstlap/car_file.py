"""Cars: presets of the simulator, or a YAML file with what differs from the default car."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path

from firstlap import _core
from firstlap.errors import InputError
from firstlap.parameters import FieldTable, Values

CAR_FIELDS = FieldTable(_core.Car.fields())
CAR_NAMES = ("default", "nuc2", "gym")


@dataclass(frozen=True)
class Car:
    """A car to simulate: geometry, vehicle, sensors and lidar, see docs/parameters.md."""

    name: str
    core: _core.Car
    source: str = ""


def load_car(spec: str | Path) -> Car:
    """The car 'default', 'nuc2' or 'gym', or the car in a YAML file. Raises InputError."""
    if str(spec) in CAR_NAMES:
        return Car(str(spec), _core.Car.preset(str(spec)), "built in")
    path = Path(spec)
    if path.suffix in (".yaml", ".yml") or path.exists():
        return _car(path.stem, CAR_FIELDS.read(path), str(path))
    near = difflib.get_close_matches(str(spec), CAR_NAMES, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"ours are {', '.join(CAR_NAMES)}"
    raise InputError(f"'{str(spec)[:200]}': no such car or file; {hint}")


def parse_car(text: str, where: str) -> Car:
    """The car in the text of a YAML file; `where` names the file in messages. Raises InputError."""
    return _car(Path(where).stem, CAR_FIELDS.parse(text, where), where)


def _car(name: str, values: Values, where: str) -> Car:
    core = _core.Car.preset("default")
    for (section, field), value in values.items():
        core.set(section, field, value)
    try:
        core.validate()
    except ValueError as error:
        raise InputError(f"{where}: {error}") from None
    return Car(name, core, where)
