"""The list of mutants matches the sources: cpp/mutants/mutants.yaml, scripts/mutants.py, docs/mutants.md."""

import importlib.util
import re
import sys
from collections import Counter
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("mutants", ROOT / "scripts/mutants.py")
assert SPEC and SPEC.loader
mutants = importlib.util.module_from_spec(SPEC)
sys.modules["mutants"] = mutants  # where dataclasses look for it
SPEC.loader.exec_module(mutants)
LIST = mutants.load()


def test_there_are_enough_of_them_with_names_of_their_own() -> None:
    assert len(LIST) >= 60
    assert [name for name, count in Counter(mutant.id for mutant in LIST).items() if count > 1] == []


def test_the_text_of_each_occurs_exactly_once_in_its_file() -> None:
    counts = {(mutant.id, mutant.file): mutant.occurrences() for mutant in LIST}
    assert {key: count for key, count in counts.items() if count != 1} == {}


def test_each_changes_something() -> None:
    assert [mutant.id for mutant in LIST if mutant.old == mutant.new or not mutant.breaks] == []


def test_the_test_of_each_exists() -> None:
    tests = mutants.tests_in(ROOT / mutants.TESTS)
    assert [(mutant.id, mutant.test) for mutant in LIST if mutant.test not in tests] == []


def test_the_page_says_that_each_is_killed() -> None:
    killed = {mutant.id: mutants.Result("killed") for mutant in LIST}
    assert mutants.PAGE.read_text() == mutants.render(LIST, killed), "run make mutants"


def test_every_step_of_the_paper_with_a_test_has_a_mutant() -> None:
    rows = [line for line in (ROOT / "docs/paper.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    named = {row: re.findall(r"`(\w+\.[\w*]+)`", row.split("|")[-2]) for row in rows}
    assert sum(bool(tests) for tests in named.values()) > 50
    without = [
        row
        for row, tests in named.items()
        if tests and not any(fnmatch(mutant.test, test) for mutant in LIST for test in tests)
    ]
    assert without == []
