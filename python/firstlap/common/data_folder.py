"""Folders of the data that ships with the package: setups, tracks, LiDARs."""

from __future__ import annotations

from pathlib import Path

from firstlap.common.errors import InputError


def data_folder(name: str) -> Path:
    """The folder `name` in the installed package, or in the source checkout around it. Raises InputError."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "data" / name, package.parents[1] / name):
        if folder.is_dir():
            return folder
    raise InputError(f"{package}: no {name} folder; expected data/{name} in the package or {name} in the checkout")
