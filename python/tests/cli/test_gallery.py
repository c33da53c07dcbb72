"""The gallery of hard cases: its plots, and the tests that it names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^firstlap explain (\S+) --at (\S+) --plot docs/(\S+)$", PAGE, re.MULTILINE)


def test_every_case_has_its_command_its_picture_and_its_tests() -> None:
    cases = PAGE.split("\n## ")[1:]
    assert len(cases) == len(COMMANDS) >= 6
    for case in cases:
        assert re.findall(r"--plot docs/(\S+)", case) == re.findall(r"!\[.+\]\((\S+)\)", case)
        assert re.search(r"^Tested by `", case, re.MULTILINE)


def test_pictures_are_there_and_small() -> None:
    shown = {ROOT / "docs" / picture for _, _, picture in COMMANDS}
    assert shown == set((ROOT / "docs" / "gallery").iterdir())
    for picture in shown:
        assert picture.read_bytes().startswith(b"\x89PNG")
        assert picture.stat().st_size < 100_000


def test_the_tests_that_hold_the_cases_exist() -> None:
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "cpp" / "tests").rglob("*_test.cpp"))
    known = {f"{suite}.{name}" for suite, name in re.findall(r"^TEST(?:_[FP])?\((\w+), (\w+)\)", sources, re.MULTILINE)}
    named = set(re.findall(r"`(\w+\.\w+)`", PAGE))
    assert named
    assert named <= known


@pytest.mark.parametrize("link", re.findall(r"\]\((adr/[^)]+)\)", PAGE))
def test_decisions_that_it_points_to_exist(link: str) -> None:
    assert (ROOT / "docs" / link).is_file()
