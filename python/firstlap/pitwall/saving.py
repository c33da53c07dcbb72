"""Saves the current setup of the pit wall as a setup file."""

from __future__ import annotations

import re
from pathlib import Path

from firstlap.common.errors import InputError
from firstlap.common.files import check_writable
from firstlap.config.parameters import Values
from firstlap.config.setup_file import Setup, list_setups, parse_setup
from firstlap.pitwall.controls import shown
from firstlap.tuning.setup_writer import setup_text, write_text

SUFFIX = ".yaml"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,60}")


def save_setup(setup: Setup, loaded: Setup, folder: Path, name: str, title: str, replace: bool) -> Path:
    """Writes folder/NAME.yaml. Raises InputError for an invalid or reserved name, or an existing file.

    title: of the source. replace: overwrite an existing file.
    """
    name = name.strip().removesuffix(SUFFIX)
    if not NAME.fullmatch(name):
        raise InputError(f"save: '{name[:60]}': expected a name of letters, digits, '_', '-' and '.'")
    if name in list_setups():
        raise InputError(f"save: {name} is a built-in setup; choose another name")
    path = folder / (name + SUFFIX)
    if path.exists() and not replace:
        raise InputError(f"save: {path.name} exists already; select 'replace' or choose another name")
    check_writable(path, (SUFFIX,))
    text = setup_text(setup.driver, _values_to_save(setup), _header(setup, loaded, name, title), setup.tuned_for)
    parse_setup(text, path.name)
    write_text(path, text)
    return path


def _values_to_save(setup: Setup) -> Values:
    """The given values; all values if there are none, since an empty file is not a setup."""
    if setup.given:
        return setup.given
    return {(section, name): value for section, rows in setup.values().items() for name, value in rows.items()}


def _header(setup: Setup, loaded: Setup, name: str, title: str) -> list[str]:
    changed = [
        f"{field.key} {shown(loaded.get(field.key))} -> {shown(setup.get(field.key))}"
        for field in setup.fields.fields
        if setup.get(field.key) != loaded.get(field.key)
    ]
    about = "; ".join(changed) if changed else "nothing"
    origin = f"at the pit wall of {_one_line(title)}, from setup {_one_line(loaded.name)}"
    return [f"Setup {name}: saved {origin}.", f"Changed: {about}."]


def _one_line(text: str) -> str:
    return " ".join(text.split())[:80]
