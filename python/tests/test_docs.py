"""The documentation: its links, the files it names, and the functions and tests of docs/paper.md."""

from __future__ import annotations

import fnmatch
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(ROOT.glob("docs/**/*.md"))]
FOLDERS = "cpp|docs|lidars|python|requirements|ros|scripts|setups|tracks"
ROW = re.compile(r"^\|[^|]*\|(?:[^|\\]|\\.)*\| (?:P|I|P, I) \| (.+?) \| (.+?) \|$", re.MULTILINE)


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_to_files_and_headings(page: Path) -> None:
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_files_that_are_named_exist(page: Path) -> None:
    named = re.findall(rf"`((?:{FOLDERS})/[\w./*-]+)`", page.read_text(encoding="utf-8"))
    assert [path for path in named if not [*ROOT.glob(path), *ROOT.glob(f"{path}.*")]] == []


def paper_rows() -> list[tuple[str, str]]:
    """(functions, tests) of each row of docs/paper.md."""
    return ROW.findall((ROOT / "docs" / "paper.md").read_text(encoding="utf-8"))


def test_functions_of_the_paper_page_exist() -> None:
    rows = paper_rows()
    assert len(rows) > 40
    for functions, _ in rows:
        for part in functions.split("; "):
            file, _, names = part.partition(": ")
            sources = [*ROOT.glob(f"cpp/firstlap/**/{file}.cpp"), *ROOT.glob(f"cpp/firstlap/**/{file}.hpp")]
            assert sources, part
            text = "".join(path.read_text(encoding="utf-8") for path in sources)
            for name in re.findall(r"`([\w:]+)`", names):
                assert re.search(rf"\b{name.rpartition('::')[2]}\b", text), part


def test_tests_of_the_paper_page_exist() -> None:
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "cpp" / "tests").rglob("*.cpp"))
    known = [".".join(names) for names in re.findall(r"^TEST(?:_[FP])?\((\w+), (\w+)\)", sources, re.MULTILINE)]
    for _, tests in paper_rows():
        for pattern in re.findall(r"`(\w+\.[\w*]+)`", tests):
            assert fnmatch.filter(known, pattern), pattern
