"""Parameter files: YAML sections checked against the field tables of the C++ core."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import parse_mapping, read_text

Value = float | int | bool
Values = dict[tuple[str, str], Value]
"""(section, name) -> value."""


REMOVED = {
    "block_overlap": "is now block_clearance",
    "response_time": "was removed; it follows from car.speed_delay and car.speed_gain",
    "slip_sigma": "is now model_acceleration_sigma",
    "servo_time": "was removed; it is car.servo_time_constant",
    "far_sigma": "was removed with its rule",
    "behind_score": "was removed with its rule",
    "bend_radius": "was removed with its rule",
    "both_share": "was removed with its rule",
}
"""Former parameters, and what to tell who still sets them."""

MAX_LISTED_NAMES = 20
"""Maximum number of names in a message."""


@dataclass(frozen=True)
class Field:
    """One row of a field table: name, unit, range, default and meaning of a parameter."""

    section: str
    name: str
    unit: str
    min: float
    max: float
    default: Value
    doc: str
    type: str

    @property
    def key(self) -> str:
        """section.name"""
        return f"{self.section}.{self.name}"

    @property
    def range(self) -> str:
        """The allowed values as text."""
        if self.type == "bool":
            return "true or false"
        kind = "an integer from " if self.type == "int" else ""
        return f"{kind}{self.min:g} to {self.max:g}{' ' + self.unit if self.unit else ''}"


class FieldTable:
    """A field table with lookup by name and error messages for wrong names and values."""

    def __init__(self, rows: Iterable[Mapping[str, Any]]) -> None:
        self.fields = [Field(**row) for row in rows]
        self.sections = list(dict.fromkeys(field.section for field in self.fields))
        self._by_key = {field.key: field for field in self.fields}

    def find(self, name: str, where: str) -> Field:
        """The field called `name` or `section.name`. Raises InputError with the nearest known names."""
        if name in self._by_key:
            return self._by_key[name]
        named = [field for field in self.fields if field.name == name]
        if len(named) == 1:
            return named[0]
        if named:
            raise InputError(f"{where}: '{name}' is in several sections: {', '.join(f.key for f in named)}")
        raise InputError(f"{where}: unknown parameter '{name[:60]}'{self._nearest(name)}")

    def _nearest(self, name: str, section: str = "") -> str:
        """A hint: what became of the name, or the most similar one in any section, or else the known names (of
        `section`, if given)."""
        bare_name = name.rpartition(".")[2]
        if bare_name in REMOVED:
            return f" ({bare_name} {REMOVED[bare_name]})"
        bare = {field.name: field.key for field in self.fields}
        near = difflib.get_close_matches(name, self._by_key, n=1, cutoff=0.6)
        near += [bare[n] for n in difflib.get_close_matches(bare_name, bare, n=1, cutoff=0.5)]
        names = [field.name for field in self.fields if field.section == section] or list(bare)
        known = ", ".join(names[:MAX_LISTED_NAMES]) + (", ..." if len(names) > MAX_LISTED_NAMES else "")
        return f" (did you mean {near[0]}?)" if near else f" (known: {known})"

    def check(self, field: Field, value: object, where: str) -> Value:
        """`value` as the type of `field` and within its range. Raises InputError."""
        number = _number(value)
        shown = "nothing" if value is None else str(value)[:60]
        if field.type == "bool" and number in (0.0, 1.0):
            return bool(number)
        if number is None or isinstance(value, bool):
            kind = "neither true nor false" if field.type == "bool" else "not a number"
            raise InputError(f"{where}: {field.key} is {shown}, which is {kind}; allowed: {field.range}")
        whole = field.type == "float" or number == int(number)
        if not (field.min <= number <= field.max and whole):
            raise InputError(f"{where}: {field.key} is {shown}; allowed: {field.range}")
        return number if field.type == "float" else int(number)

    def parse_assignment(self, text: str, option: str = "--set", example: str = "k_ang=0.3") -> tuple[Field, Value]:
        """Parses NAME=VALUE, as given to --set. Raises InputError."""
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(f"{option} {text[:60]}: expected NAME=VALUE, for example {option} {example}")
        field = self.find(name.strip(), option)
        return field, self.check(field, value.strip(), option)

    def read(self, path: Path) -> Values:
        """The values in a YAML file of sections. Raises InputError."""
        return self.parse(read_text(path), str(path))

    def parse(self, text: str, where: str) -> Values:
        """The values in the text of a YAML file; `where` names the file in messages. Raises InputError."""
        if not has_information(text):
            raise InputError(f"{where}: contains only comments; expected sections ({', '.join(self.sections)})")
        return self.check_sections(parse_mapping(text, where), where)

    def check_sections(self, data: Mapping[Any, Any], where: str) -> Values:
        """The values in {section: {name: value}}; `where` names the file in messages. Raises InputError."""
        values: Values = {}
        for section, content in data.items():
            if section not in self.sections:
                raise InputError(f"{where}: unknown section '{str(section)[:60]}'{self._nearest_section(section)}")
            if not isinstance(content, dict):
                raise InputError(f"{where}: section {section} is not a list of 'name: value' lines")
            for name, value in content.items():
                field = self._by_key.get(f"{section}.{name}")
                if field is None:
                    hint = self._nearest(str(name), section)
                    raise InputError(f"{where}: unknown key '{section}.{str(name)[:60]}'{hint}")
                values[section, field.name] = self.check(field, value, where)
        return values

    def _nearest_section(self, name: object) -> str:
        near = difflib.get_close_matches(str(name), self.sections, n=1, cutoff=0.5)
        if near:
            return f" (did you mean {near[0]}?)"
        owners = [field.section for field in self.fields if field.name == name]
        if owners:
            return f" ('{name}' belongs under {owners[0]})"
        return f" (known: {', '.join(self.sections)})"


def has_information(text: str) -> bool:
    """Whether a YAML text contains more than comments."""
    return any(line.split("#")[0].strip(" \t\r-.") for line in text.splitlines())


def _number(value: object) -> float | None:
    """A finite number, also from text that YAML 1.1 does not parse as one (1e-3); None otherwise."""
    if isinstance(value, str) and value.strip().lower() in ("true", "false"):
        return float(value.strip().lower() == "true")
    if not isinstance(value, int | float | str):
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    return number if abs(number) < float("inf") else None
