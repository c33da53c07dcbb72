"""Questions change nothing: a method that answers one writes no attribute of its object."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import firstlap

ROOT = Path(firstlap.__file__).parent
ASKS = "is has may can lacks needs wants fits covers knows".replace(" ", "|")
QUESTION = re.compile(rf"_?(({ASKS})_\w+|(\w+_)?(reason|ready|missing|is_due))")
CHANGING = {"append", "add", "clear", "discard", "extend", "insert", "pop", "popleft", "remove", "setdefault", "update"}


def questions() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Properties, and methods that are named like a question, with their places."""
    for path in sorted(ROOT.rglob("*.py")):
        for owner in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for method in owner.body if isinstance(owner, ast.ClassDef) else []:
                if isinstance(method, ast.FunctionDef):
                    decorators = [ast.unparse(one) for one in method.decorator_list]
                    if "property" in decorators or QUESTION.fullmatch(method.name):
                        yield f"{path.relative_to(ROOT)}: {owner.name}.{method.name}", method


def changes_of(method: ast.FunctionDef) -> list[str]:
    """What a method writes of its own object."""
    written = []
    for node in ast.walk(method):
        if isinstance(node, ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store | ast.Del):
            written.append(node)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGING:
            written.append(node.func.value)
    return [text for text in map(ast.unparse, written) if text.startswith("self.")]


def test_questions_change_nothing() -> None:
    found = dict(questions())
    assert len(found) > 50
    changing = {name: changes for name, method in found.items() if (changes := changes_of(method))}
    assert not changing
