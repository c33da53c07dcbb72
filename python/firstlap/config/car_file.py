"""Cars: presets of the simulator, or a YAML file with the differences from the default car."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path

from firstlap import _core
from firstlap.common.data_folder import data_folder
from firstlap.common.errors import InputError
from firstlap.config.parameters import FieldTable, Values

CAR_FIELDS = FieldTable(_core.Car.fields())
CAR_NAMES = ("default", "nuc2", "gym")


def car_section(name: str) -> str:
    """The section of a car that holds what the section `car` of a setup calls so: its geometry or its vehicle."""
    return CAR_FIELDS.find(name, "car").section


@dataclass(frozen=True)
class Car:
    """A simulated car: geometry, vehicle, sensors and LiDAR, see docs/parameters.md."""

    name: str
    core: _core.Car
    source: str = ""


def load_car(spec: str | Path) -> Car:
    """The car 'default', 'nuc2' or 'gym', or the car in a YAML file. Raises InputError."""
    if str(spec) in CAR_NAMES:
        return Car(str(spec), _core.Car.preset(str(spec)), "built in")
    path = Path(spec)
    if path.suffix in (".yaml", ".yml") or (str(spec) and path.exists()):
        return _car(path.stem, CAR_FIELDS.read(path), str(path))
    near = difflib.get_close_matches(str(spec), CAR_NAMES, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"available: {', '.join(CAR_NAMES)}"
    raise InputError(f"'{str(spec)[:200]}': no such car or file; {hint}")


def list_lidars() -> list[str]:
    """Names of the available LiDARs, sorted."""
    return sorted(path.stem for path in data_folder("lidars").glob("*.yaml"))


def with_lidar(car: Car, spec: str | Path | None) -> Car:
    """The car with another LiDAR: one of ours by name, or the section `lidar` of a YAML file. Raises InputError.

    Values that the file does not set are those of the default car. None: the car is returned unchanged.
    """
    if spec is None:
        return car
    path = _lidar_file(spec)
    values = CAR_FIELDS.read(path)
    for section, name in values:
        if section != "lidar":
            raise InputError(f"{path}: {section}.{name} is not a LiDAR parameter; expected only the section 'lidar'")
    core = _core.Car(car.core)
    for field in CAR_FIELDS.fields:
        if field.section == "lidar":
            core.set("lidar", field.name, values.get(("lidar", field.name), field.default))
    return _valid(Car(f"{car.name} with {path.stem}", core, car.source), str(path))


def _lidar_file(spec: str | Path) -> Path:
    if str(spec) in list_lidars():
        return data_folder("lidars") / f"{spec}.yaml"
    path = Path(spec)
    if path.suffix in (".yaml", ".yml") or (str(spec) and path.exists()):
        return path
    near = difflib.get_close_matches(str(spec), list_lidars(), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"available: {', '.join(list_lidars())}"
    raise InputError(f"'{str(spec)[:200]}': no such LiDAR or file; {hint}")


def parse_car(text: str, where: str) -> Car:
    """The car in the text of a YAML file; `where` names the file in messages. Raises InputError."""
    return _car(Path(where).stem, CAR_FIELDS.parse(text, where), where)


def _car(name: str, values: Values, where: str) -> Car:
    core = _core.Car.preset("default")
    for (section, field), value in values.items():
        core.set(section, field, value)
    return _valid(Car(name, core, where), where)


def _valid(car: Car, where: str) -> Car:
    try:
        car.core.validate()
    except ValueError as error:
        raise InputError(f"{where}: {error}") from None
    return car
