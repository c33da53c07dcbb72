"""Measure which lines and branches the tests run, in C++ (gcov through gcovr) and in Python (coverage.py).

Prints a table with a row per layer or package and writes it to build/coverage/coverage.md; build/coverage/html has
every line.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build/coverage"
HTML = BUILD / "html"
PAGE = BUILD / "coverage.md"

HEAD = """# Coverage

Lines and branches that run in the C++ tests and in the Python tests (without those over DDS, `make test-ros`). Whether
a test would detect a fault there is another question: docs/mutants.md. In C++, branches that the compiler adds for
exceptions are excluded.
"""


@dataclass
class Count:
    """Covered and total numbers of lines and branches."""

    lines: int = 0
    lines_run: int = 0
    branches: int = 0
    branches_run: int = 0

    def add(self, other: Count) -> None:
        self.lines += other.lines
        self.lines_run += other.lines_run
        self.branches += other.branches
        self.branches_run += other.branches_run


def run(*command: str | Path) -> None:
    """Runs a command; ends the script if it fails."""
    done = subprocess.run(command, cwd=ROOT, check=False)
    if done.returncode != 0:
        sys.exit(f"error: {' '.join(map(str, command))} ended with {done.returncode}")


def measure_cpp() -> dict[str, Count]:
    """Coverage by layer."""
    run("cmake", "--preset", "coverage")
    run("cmake", "--build", "--preset", "coverage")
    for old in BUILD.rglob("*.gcda"):
        old.unlink()
    run(BUILD / "cpp/firstlap_tests", "--gtest_brief=1")
    summary = BUILD / "cpp.json"
    (HTML / "cpp").mkdir(parents=True, exist_ok=True)
    filters = ("--filter", "cpp/firstlap/", "--exclude-throw-branches", "--exclude-unreachable-branches")
    reports = ("--json-summary", summary, "--html-details", HTML / "cpp/index.html")
    run("gcovr", "--root", ROOT, *filters, *reports, BUILD / "cpp")
    return by_folder(
        (
            source(file["filename"]).relative_to("cpp/firstlap"),
            Count(file["line_total"], file["line_covered"], file["branch_total"], file["branch_covered"]),
        )
        for file in json.loads(summary.read_text())["files"]
    )


def source(name: str) -> Path:
    """The source file, relative to the root, of a file of the report, where headers have the name of the link in the
    build folder through which their layer includes them."""
    return (ROOT / name).resolve().relative_to(ROOT)


def measure_python() -> dict[str, Count]:
    """Coverage by package."""
    summary = BUILD / "python.json"
    reports = (f"--cov-report=json:{summary}", f"--cov-report=html:{HTML / 'python'}")
    jobs = str(os.cpu_count() or 1)
    run("pytest", "--quiet", "--numprocesses", jobs, "--cov=firstlap", "--cov-branch", *reports)
    files = {Path(name): file["summary"] for name, file in json.loads(summary.read_text())["files"].items()}
    return by_folder(
        (
            name.relative_to("python/firstlap"),
            Count(file["num_statements"], file["covered_lines"], file["num_branches"], file["covered_branches"]),
        )
        for name, file in files.items()
    )


def by_folder(files: Iterable[tuple[Path, Count]]) -> dict[str, Count]:
    """Sums over the files of each folder; top-level files count as folder "."."""
    sums: dict[str, Count] = defaultdict(Count)
    for path, count in files:
        sums[path.parts[0] if len(path.parts) > 1 else "."].add(count)
    return dict(sorted(sums.items()))


def share(part: int, whole: int) -> str:
    return f"{100 * part / whole:.1f} %" if whole else "-"


def table(title: str, counts: dict[str, Count]) -> str:
    """One Markdown table, with the total in the last row."""
    every = Count()
    lines = [f"| {title} | lines | covered | branches | covered |", "|---|--:|--:|--:|--:|"]
    for count in counts.values():
        every.add(count)
    for name, count in [*counts.items(), ("**all**", every)]:
        covered = share(count.lines_run, count.lines), share(count.branches_run, count.branches)
        lines.append(f"| {name} | {count.lines} | {covered[0]} | {count.branches} | {covered[1]} |")
    return "\n".join(lines)


def main() -> None:
    tables = [table("C++ layer", measure_cpp()), table("Python package", measure_python())]
    PAGE.write_text("\n".join([HEAD, *(f"{text}\n" for text in tables)]))
    pages = [f"{HTML.relative_to(ROOT)}/{name}/index.html" for name in ("cpp", "python")]
    print("\n\n".join([*tables, "\n".join(pages)]))


if __name__ == "__main__":
    main()
