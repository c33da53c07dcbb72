"""Setups: one YAML file of parameters each, holding what differs from the defaults of the C++ core."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from firstlap import _core
from firstlap.errors import InputError
from firstlap.parameters import FieldTable, Value, Values

SETUP_FIELDS = FieldTable(_core.Params.fields())


@dataclass(frozen=True)
class Setup:
    """A set of parameters. Immutable: `with_values` gives a changed copy.

    given: what the file and the changes after it say; everything else is at its default.
    """

    name: str
    given: Values = field(default_factory=dict)
    source: str = ""
    changed: Values = field(default_factory=dict)

    def with_values(self, values: Mapping[str, Value]) -> Setup:
        """A copy with e.g. {"k_ang": 0.3, "stanley.k_dist": 1.0}. Raises InputError: name, value, range."""
        new: Values = {}
        for name, value in values.items():
            entry = SETUP_FIELDS.find(name, "setup")
            new[entry.section, entry.name] = SETUP_FIELDS.check(entry, value, "setup")
        return self._with(new, "setup")

    def with_assignments(self, assignments: list[str]) -> Setup:
        """A copy with ["k_ang=0.3", ...], as of the option --set. Raises InputError."""
        new: Values = {}
        for text in assignments:
            entry, value = SETUP_FIELDS.parse_assignment(text)
            new[entry.section, entry.name] = value
        return self._with(new, "--set")

    def _with(self, new: Values, where: str) -> Setup:
        setup = replace(self, given={**self.given, **new}, changed={**self.changed, **new})
        setup.validate(where)
        return setup

    def with_given(self, values: Values) -> Setup:
        """A copy with values that a recording asks for; they do not count as changed by a person."""
        return replace(self, given={**self.given, **values})

    def validate(self, where: str) -> None:
        """Raises InputError where values contradict each other."""
        try:
            self.params().validate()
        except ValueError as error:
            raise InputError(f"{where}: {error}") from None

    def params(self, car: _core.Car | None = None) -> _core.Params:
        """For the core. With a car, its body replaces what the setup does not say itself."""
        params = _core.Params()
        if car is not None:
            for name, value in car.values()["geometry"].items():
                params.set("car", name, value)
        for (section, name), value in self.given.items():
            params.set(section, name, value)
        return params

    def values(self) -> dict[str, dict[str, Value]]:
        """Every parameter, {section: {name: value}}."""
        return self.params().values()

    def get(self, name: str) -> Value:
        """One parameter by its name or section.name. Raises InputError."""
        entry = SETUP_FIELDS.find(name, "setup")
        return self.given.get((entry.section, entry.name), entry.default)


def setups_folder() -> Path:
    """Where our own setups lie: in the installed package, or in the source checkout around it."""
    package = Path(__file__).resolve().parent
    for folder in (package / "data" / "setups", package.parents[1] / "setups"):
        if folder.is_dir():
            return folder
    raise InputError(f"{package}: no setups folder; expected data/setups in the package or setups in the checkout")


def list_setups() -> list[str]:
    """Names of our own setups, sorted."""
    return sorted(path.stem for path in setups_folder().glob("*.yaml"))


def load_setup(spec: str | Path) -> Setup:
    """A setup of ours by its name, or the setup in a YAML file. Raises InputError."""
    if str(spec) in list_setups():
        return _read(setups_folder() / f"{spec}.yaml", str(spec))
    path = Path(spec)
    if path.suffix in (".yaml", ".yml") or path.exists():
        return _read(path, path.stem)
    near = difflib.get_close_matches(str(spec), list_setups(), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"ours are {', '.join(list_setups())}"
    raise InputError(f"'{str(spec)[:200]}': no such setup or file; {hint}")


def parse_setup(text: str, where: str) -> Setup:
    """The setup in the text of a YAML file; `where` names the file in messages. Raises InputError."""
    setup = Setup(Path(where).stem, SETUP_FIELDS.parse(text, where), where)
    setup.validate(where)
    return setup


def _read(path: Path, name: str) -> Setup:
    setup = Setup(name, SETUP_FIELDS.read(path), str(path))
    setup.validate(str(path))
    return setup
