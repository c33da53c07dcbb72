"""Field tables of parameters that exist only in Python, made from the metadata of frozen dataclasses."""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any, TypeVar

from firstlap.common.errors import InputError
from firstlap.config.parameters import FieldTable, Value, Values

Section = TypeVar("Section")


def row(default: Value, unit: str, low: float, high: float, doc: str) -> Any:
    """A field of a parameter dataclass: default, unit, allowed range and meaning."""
    kind = type(default).__name__
    return field(default=default, metadata={"unit": unit, "min": low, "max": high, "doc": doc, "type": kind})


def table_of(**sections: type) -> FieldTable:
    """The field table of parameter dataclasses, given by section name."""
    return FieldTable(
        {"section": section, "name": entry.name, "default": entry.default, **entry.metadata}
        for section, kind in sections.items()
        for entry in fields(kind)
    )


def from_values(kind: type[Section], section: str, values: Values) -> Section:
    """The dataclass of a section with `values`, which must already be checked, and defaults for all others."""
    return kind(**{name: value for (owner, name), value in values.items() if owner == section})


def check_values(table: FieldTable, given: dict[str, object], where: str) -> Values:
    """Values by name, checked against the table. Raises InputError with name, value and range."""
    checked: Values = {}
    for name, value in given.items():
        entry = table.find(name, where)
        checked[entry.section, entry.name] = table.check(entry, value, where)
    if not checked and given:
        raise InputError(f"{where}: nothing to set")
    return checked
