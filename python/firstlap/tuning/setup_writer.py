"""Writes setup files with a header that documents their origin."""

from __future__ import annotations

import textwrap
from pathlib import Path

import yaml

from firstlap.common.files import write_whole
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import Values
from firstlap.config.setup_file import LOCAL, TUNED_FOR


def setup_text(driver: str, given: Values, header: list[str], tuned_for: str = "") -> str:
    """The text of a setup file; header: lines, wrapped, each a comment; tuned_for: as of `Setup`."""
    lines = [part for line in header for part in (textwrap.wrap(line, 110) or [""])]
    text = "".join(f"# {line}".rstrip() + "\n" for line in lines)
    sections: dict[str, dict[str, object]] = {}
    for field in driver_kind(driver).fields.fields:
        if (field.section, field.name) in given:
            sections.setdefault(field.section, {})[field.name] = given[field.section, field.name]
    first = f"driver: {driver}\n" if driver != LOCAL else ""
    first += yaml.safe_dump({TUNED_FOR: tuned_for}, allow_unicode=True) if tuned_for else ""
    return text + first + (yaml.safe_dump(sections, sort_keys=False) if sections else "")


def write_setup(path: Path, driver: str, given: Values, header: list[str], tuned_for: str = "") -> None:
    """Writes a setup file atomically. Raises InputError."""
    text = setup_text(driver, given, header, tuned_for)
    write_whole(path, lambda name: _write(name, text))


def write_text(path: Path, text: str) -> None:
    """Writes text atomically. Raises InputError."""
    write_whole(path, lambda name: _write(name, text))


def _write(name: str, text: str) -> None:
    Path(name).write_text(text, encoding="utf-8")
