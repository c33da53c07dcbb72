"""Setups: YAML files with the parameters that differ from the driver's defaults."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from firstlap import _core
from firstlap.common.data_folder import data_folder
from firstlap.common.errors import InputError
from firstlap.common.yaml_text import parse_mapping, read_text
from firstlap.config.car_file import car_section
from firstlap.config.driver_kind import Params, driver_kind
from firstlap.config.parameters import FieldTable, Value, Values, has_information

LOCAL = "local"
DEFAULT_SETUP = "sure"
"""What drives if neither a driver nor a setup is named, everywhere (docs/adr/0013-defaults.md)."""
BASE = "base"
"""The paper's base setting; its values are the defaults of `SETUP_FIELDS` and of the C++ core."""
TUNED_FOR = "tuned_for"
"""Key of a setup file: the tracks for which a search found it."""
MAX_TUNED_FOR = 300
SETUP_FIELDS = FieldTable(_core.Params.fields())


@dataclass(frozen=True)
class Setup:
    """Parameters of one driver. Immutable: `with_values` returns a changed copy.

    given: values set by the file and later changes; all others are at their defaults. tuned_for: the tracks for which a
    search found it; empty if none did.
    """

    name: str
    given: Values = field(default_factory=dict)
    source: str = ""
    changed: Values = field(default_factory=dict)
    driver: str = LOCAL
    tuned_for: str = ""

    @property
    def fields(self) -> FieldTable:
        """The field table of the driver."""
        return driver_kind(self.driver).fields

    @property
    def tuning(self) -> str:
        """Whether it was tuned, and for what: "tuned for arena", "untuned"."""
        return f"tuned for {self.tuned_for}" if self.tuned_for else "untuned"

    @property
    def title(self) -> str:
        """Driver and setup for output: "setup race", "driver gap, setup gap_arena"."""
        return f"setup {self.name}" if self.driver == LOCAL else f"driver {self.driver}, setup {self.name}"

    def with_values(self, values: Mapping[str, Value]) -> Setup:
        """A copy with e.g. {"k_ang": 0.3, "stanley.k_dist": 1.0}. Raises InputError with name, value and range."""
        new: Values = {}
        for name, value in values.items():
            entry = self.fields.find(name, "setup")
            new[entry.section, entry.name] = self.fields.check(entry, value, "setup")
        return self._with(new, "setup")

    def with_assignments(self, assignments: list[str]) -> Setup:
        """A copy with ["k_ang=0.3", ...], as given to --set. Raises InputError."""
        new: Values = {}
        for text in assignments:
            entry, value = self.fields.parse_assignment(text)
            new[entry.section, entry.name] = value
        return self._with(new, "--set")

    def _with(self, new: Values, where: str) -> Setup:
        setup = replace(self, given={**self.given, **new}, changed={**self.changed, **new})
        setup.validate(where)
        return setup

    def with_given(self, values: Values) -> Setup:
        """A copy with values from a recording; they are not recorded as changed by the user."""
        return replace(self, given={**self.given, **values})

    def validate(self, where: str, car: _core.Car | None = None) -> None:
        """Raises InputError if values contradict each other or those of the car."""
        try:
            self.params(car).validate()
        except ValueError as error:
            raise InputError(f"{where}: {error}") from None

    def params(self, car: _core.Car | None = None) -> Any:
        """The parameters for the driver (`_core.Params` for local). With a car, its geometry and dynamics are used for
        `car.*` values that the setup does not set."""
        params: Params = driver_kind(self.driver).new_params()
        configured = self if car is None else self.with_car_values(car)
        for (section, name), value in configured.given.items():
            params.set(section, name, value)
        return params

    def with_car_values(self, car: _core.Car) -> Setup:
        """A copy that also sets the `car.*` values of a car, so that the driver keeps them in another car."""
        values, names = car.values(), [entry.name for entry in self.fields.fields if entry.section == "car"]
        known: Values = {("car", name): values[car_section(name)][name] for name in names}
        return replace(self, given={**known, **self.given})

    def values(self) -> dict[str, dict[str, Value]]:
        """Every parameter, {section: {name: value}}."""
        return self.params().values()

    def get(self, name: str) -> Value:
        """One parameter by its name or section.name. Raises InputError."""
        entry = self.fields.find(name, "setup")
        return self.given.get((entry.section, entry.name), entry.default)


def setups_folder() -> Path:
    """The folder of our own setups, in the installed package or in the source checkout."""
    return data_folder("setups")


def list_setups(driver: str | None = None) -> list[str]:
    """Names of our own setups, sorted; all, or those of one driver."""
    names = sorted(path.stem for path in setups_folder().glob("*.yaml"))
    return [name for name in names if driver is None or load_setup(name).driver == driver]


def load_setup(spec: str | Path, driver: str | None = None) -> Setup:
    """A setup of ours by its name, or the setup in a YAML file. Raises InputError, also if it is for another driver.

    A setup file names its driver with a line `driver: NAME`; without one, it is for `local`. A line `tuned_for: TRACKS`
    says that a search found it on them.
    """
    setup = _load(spec)
    if driver is not None and setup.driver != driver:
        ours = ", ".join(list_setups(driver)) or "none"
        raise InputError(
            f"setup {setup.name} ({setup.source}) is for driver {setup.driver}, not for {driver}; "
            f"available for {driver}: {ours}"
        )
    return setup


def choose_setup(driver: str | None, setup: str | Path | Setup | None) -> Setup:
    """The setup for the given driver and setup, either of which may be None. Raises InputError.

    Neither: `DEFAULT_SETUP`. Only a driver: its default setup. Only a setup: the driver named in it.
    """
    if driver is not None:
        driver_kind(driver)
    if isinstance(setup, Setup):
        if driver is not None and setup.driver != driver:
            raise InputError(f"setup {setup.name} is for driver {setup.driver}, not for {driver}")
        return setup
    if setup is None:
        return load_setup(driver_kind(driver or LOCAL).default_setup, driver)
    return load_setup(setup, driver)


def _load(spec: str | Path) -> Setup:
    names = sorted(path.stem for path in setups_folder().glob("*.yaml"))
    if str(spec) in names:
        return _read(setups_folder() / f"{spec}.yaml", str(spec))
    path = Path(spec)
    if path.suffix in (".yaml", ".yml") or (str(spec) and path.exists()):
        return _read(path, path.stem)
    near = difflib.get_close_matches(str(spec), names, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"available: {', '.join(names)}"
    raise InputError(f"'{str(spec)[:200]}': no such setup or file; {hint}")


def parse_setup(text: str, where: str, name: str | None = None) -> Setup:
    """The setup in the text of a YAML file; `where` names the file in messages. Raises InputError."""
    if not has_information(text):
        raise InputError(f"{where}: contains only comments; expected sections ({', '.join(SETUP_FIELDS.sections)})")
    data = dict(parse_mapping(text, where))
    kind = driver_kind(data.pop("driver", LOCAL), f"{where}: driver")
    tuned_for = _tuned_for(data, where)
    values = kind.fields.check_sections(data, where)
    setup = Setup(name or Path(where).stem, values, where, driver=kind.name, tuned_for=tuned_for)
    setup.validate(where)
    return setup


def _tuned_for(data: dict[Any, Any], where: str) -> str:
    text = data.pop(TUNED_FOR, "")
    if not isinstance(text, str) or len(text) > MAX_TUNED_FOR or not text.isprintable():
        raise InputError(f"{where}: {TUNED_FOR} is {str(text)[:60]!r}; expected a track's name, for example arena")
    return text


def _read(path: Path, name: str) -> Setup:
    return parse_setup(read_text(path), str(path), name)
