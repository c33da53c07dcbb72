"""Parameters that only Python has: a frozen dataclass is the table, its rows are the fields' metadata."""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any, TypeVar

from firstlap.common.errors import InputError
from firstlap.config.parameters import FieldTable, Value, Values

Section = TypeVar("Section")


def row(default: Value, unit: str, low: float, high: float, doc: str) -> Any:
    """A field of a parameter dataclass: default, unit, allowed range, what it is."""
    kind = type(default).__name__
    return field(default=default, metadata={"unit": unit, "min": low, "max": high, "doc": doc, "type": kind})


def table_of(**sections: type) -> FieldTable:
    """The field table of parameter dataclasses, named by their sections."""
    return FieldTable(
        {"section": section, "name": entry.name, "default": entry.default, **entry.metadata}
        for section, kind in sections.items()
        for entry in fields(kind)
    )


def from_values(kind: type[Section], section: str, values: Values) -> Section:
    """The dataclass of a section with what `values` say and its defaults. Values are checked before."""
    return kind(**{name: value for (owner, name), value in values.items() if owner == section})


def check_values(table: FieldTable, given: dict[str, object], where: str) -> Values:
    """Values by name, checked against the table. Raises InputError: name, value, range."""
    checked: Values = {}
    for name, value in given.items():
        entry = table.find(name, where)
        checked[entry.section, entry.name] = table.check(entry, value, where)
    if not checked and given:
        raise InputError(f"{where}: nothing to set")
    return checked
