"""Imports: all names that tests, scripts and fuzzers import exist, and the command line starts without heavy ones."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(
    path for folder in ("python/tests", "python/fuzz", "scripts", "ros") for path in (ROOT / folder).rglob("*.py")
)


def imported(path: Path) -> set[tuple[str, str]]:
    """(module, name) of every `from firstlap... import ...`, also inside functions."""
    nodes = (node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.ImportFrom))
    return {
        (node.module, name.name)
        for node in nodes
        if node.module and node.module.split(".")[0] == "firstlap"
        for name in node.names
    }


def is_there(module: str, name: str) -> bool:
    """Whether the name exists; also true if a dependency is not installed."""
    try:
        if hasattr(importlib.import_module(module), name):
            return True
        importlib.import_module(f"{module}.{name}")
    except ModuleNotFoundError as error:
        return not str(error.name).startswith("firstlap")
    return True


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_is_imported_is_there(path: Path) -> None:
    assert [pair for pair in sorted(imported(path)) if not is_there(*pair)] == []


HEAVY = {"scipy", "matplotlib", "pandas", "optuna", "dask", "distributed", "casadi", "osqp", "viser", "rclpy", "jinja2"}
"""Packages that a command imports only when it needs them: together they take seconds."""


def test_the_command_line_starts_without_heavy_packages() -> None:
    script = "import sys, firstlap.cli; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    assert "firstlap.cli" in loaded
    assert sorted(HEAVY & set(loaded)) == []
