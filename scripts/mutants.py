"""Apply each change listed in cpp/mutants/mutants.yaml, and check whether the named test fails.

Usage: scripts/mutants.py [--only ID]... [--fresh] [--jobs N]

The sources are not modified: the tests are built once (build/tests); then one file per mutant is compiled and linked
before the library with the original. Exit code 1: a mutant survives, is only detected by other tests than the named
one, does not build, or its text does not occur exactly once in its file. Results are kept in build/mutants until the
mutant, its file or its test changes. When all mutants have a result, docs/mutants.md is written.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

import yaml
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT / "cpp/mutants/mutants.yaml"
PAGE = ROOT / "docs/mutants.md"
CORE = Path("cpp/firstlap")
TESTS = Path("cpp/tests")
BUILD = ROOT / "build/tests"
EXECUTABLE = Path("cpp/firstlap_tests")  # in BUILD
WORK = ROOT / "build/mutants"
RESULTS = WORK / "results.json"
LONGEST_TEST = 600.0  # [s] timeout; a hanging test counts as killed

HEAD = """<!-- Written by `make mutants`. Do not edit. -->

# Mutants

A test suite is as good as the faults that it notices. [cpp/mutants/mutants.yaml](../cpp/mutants/mutants.yaml) lists
changes of the method, at least one for each equation and rule of [paper.md](paper.md). `make mutants` builds the tests
with each of them and runs the one that is named here; it fails where that test still passes.

"""


@dataclass(frozen=True)
class Mutant:
    """One change: `old`, which occurs once in `file` (in cpp/firstlap), becomes `new`; `test` must fail then."""

    id: str
    step: str
    file: str
    old: str
    new: str
    breaks: str
    test: str

    @property
    def path(self) -> Path:
        return CORE / self.file

    def occurrences(self, root: Path = ROOT) -> int:
        """Number of occurrences of its text in its file; 0 without the file."""
        path = root / self.path
        return path.read_text().count(self.old) if path.is_file() else 0


@dataclass(frozen=True)
class Result:
    """The result of a mutant: killed, misnamed (detected by other tests), survived, not built, stale (no such text)."""

    status: str
    detail: str = ""
    digest: str = ""


def load(path: Path = LIST) -> list[Mutant]:
    """All mutants, in the order of the list."""
    steps = yaml.safe_load(path.read_text())
    return [Mutant(step=step, **fields) for step, entries in steps.items() for fields in entries]


def tests_in(folder: Path) -> dict[str, Path]:
    """GoogleTest's tests: name -> file."""
    pattern = re.compile(r"^TEST(?:_F)?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)
    return {
        f"{suite}.{name}": path
        for path in sorted(folder.rglob("*.cpp"))
        for suite, name in pattern.findall(path.read_text())
    }


def text_of_test(name: str, path: Path) -> str:
    """The source of a test, from its first line to its closing brace."""
    text = path.read_text()
    suite, test = name.split(".")
    start = re.search(rf"^TEST(?:_F)?\(\s*{suite},\s*{test}\)", text, re.MULTILINE)
    return text[start.start() : text.index("\n}\n", start.start())] if start else ""


def digest(mutant: Mutant, tests: dict[str, Path]) -> str:
    """A hash of the mutant, its file and its test."""
    parts = [json.dumps(asdict(mutant))]
    if (ROOT / mutant.path).is_file():
        parts.append((ROOT / mutant.path).read_text())
    if path := tests.get(mutant.test):
        parts.append(text_of_test(mutant.test, path))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def run(command: list[str], seconds: float | None = None) -> tuple[bool, str]:
    """Runs a command; returns success and output."""
    try:
        done = subprocess.run(command, cwd=BUILD, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return False, "[  FAILED  ] timeout"
    return done.returncode == 0, done.stdout + done.stderr


class Builder:
    """Builds the original tests, and tests with one changed file."""

    def __init__(self) -> None:
        for step in (["cmake", "--preset", "tests"], ["cmake", "--build", "--preset", "tests"]):
            done = subprocess.run(step, cwd=ROOT, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                sys.exit(f"error: without a mutant {shlex.join(step)} fails\n{done.stdout}{done.stderr}")
        entries = json.loads((BUILD / "compile_commands.json").read_text())
        self._compile = {Path(entry["file"]): shlex.split(entry["command"]) for entry in entries}
        _, commands = run(["ninja", "-t", "commands", str(EXECUTABLE)])
        self._link = shlex.split(commands.splitlines()[-1].removeprefix(": && ").removesuffix(" && :"))

    def build(self, mutant: Mutant, folder: Path) -> tuple[bool, str]:
        """Links the test executable `folder/tests`; its object precedes the library, so that the linker does not take
        the original."""
        source, product = folder / "mutant.cpp", folder / "mutant.o"
        original = ROOT / mutant.path
        source.write_text(original.read_text().replace(mutant.old, mutant.new))
        command = self._compile[original]
        command = [str(source) if word == str(original) else word for word in command]
        command[command.index("-o") + 1] = str(product)
        built, output = run([*command, "-O1", "-w"])
        if not built:
            return False, output
        at = self._link.index("-o")
        return run([*self._link[:at], str(product), "-o", str(folder / "tests"), *self._link[at + 2 :]])


def run_tests(executable: Path, names: list[str]) -> tuple[bool, str]:
    return run([str(executable), f"--gtest_filter={':'.join(names)}", "--gtest_brief=1"], LONGEST_TEST)


def failed_tests(output: str) -> str:
    """The first failed tests."""
    names = re.findall(r"^\[  FAILED  \] ([\w.]+)", output, re.MULTILINE)
    return names[0] if names else "the test executable did not finish"


def try_mutant(mutant: Mutant, builder: Builder) -> Result:
    """Runs the named test, then all tests of its layer."""
    if (count := mutant.occurrences()) != 1:
        return Result("stale", f"its text occurs {count} times in {mutant.path}")
    with tempfile.TemporaryDirectory(dir=WORK) as name:
        folder = Path(name)
        built, output = builder.build(mutant, folder)
        if not built:
            return Result("not built", next((line for line in output.splitlines() if "error" in line), ""))
        if not run_tests(folder / "tests", [mutant.test])[0]:
            return Result("killed")
        passed, output = run_tests(folder / "tests", list(tests_in(ROOT / TESTS / mutant.path.parent.name)))
        return Result("survived") if passed else Result("misnamed", f"noticed by {failed_tests(output)} only")


def remembered() -> dict[str, Result]:
    """Results of earlier runs."""
    if not RESULTS.is_file():
        return {}
    return {name: Result(**fields) for name, fields in json.loads(RESULTS.read_text()).items()}


def remember(results: dict[str, Result]) -> None:
    RESULTS.write_text(json.dumps({name: asdict(result) for name, result in results.items()}, indent=1))


def render(mutants: list[Mutant], results: dict[str, Result]) -> str:
    """docs/mutants.md."""
    killed = sum(results[mutant.id].status == "killed" for mutant in mutants)
    parts = [HEAD + f"{killed} of {len(mutants)} mutants are killed by the test that is named.\n"]
    for step in dict.fromkeys(mutant.step for mutant in mutants):
        parts.append(f"\n## {step.capitalize()}\n\n| mutant | what it breaks | file | killed by |\n|---|---|---|---|\n")
        for mutant in mutants:
            if mutant.step == step:
                result = results[mutant.id]
                outcome = f"`{mutant.test}`" if result.status == "killed" else f"**{result.status}** {result.detail}"
                parts.append(f"| {mutant.id} | {mutant.breaks} | {mutant.file} | {outcome.rstrip()} |\n")
    return "".join(parts)


def try_all(pending: list[Mutant], jobs: int, done: Callable[[Mutant, Result], None]) -> None:
    """Calls `done` with each result, and prints the mutants that are not killed."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress, ThreadPoolExecutor(jobs) as pool:
        task = progress.add_task("building", total=len(pending))
        builder = Builder()
        passed, output = run_tests(BUILD / EXECUTABLE, sorted({mutant.test for mutant in pending}))
        if not passed:
            sys.exit(f"error: without a mutant {failed_tests(output)} fails already")
        futures = {pool.submit(try_mutant, mutant, builder): mutant for mutant in pending}
        for future in as_completed(futures):
            mutant, result = futures[future], future.result()
            done(mutant, result)
            progress.update(task, description=mutant.id, advance=1)
            if result.status != "killed":
                console.print(f"{mutant.id}: {result.status} {result.detail}".rstrip(), highlight=False)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--only", action="append", default=[], metavar="ID", help="run only this mutant (repeatable)")
    parser.add_argument("--fresh", action="store_true", help="discard earlier results")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="number of parallel jobs")
    return parser.parse_args()


def main() -> int:
    options = arguments()
    mutants = load()
    if unknown := set(options.only) - {mutant.id for mutant in mutants}:
        print(f"error: no mutant {', '.join(sorted(unknown))} in {LIST.relative_to(ROOT)}", file=sys.stderr)
        return 2
    tests = tests_in(ROOT / TESTS)
    digests = {mutant.id: digest(mutant, tests) for mutant in mutants}
    known = {} if options.fresh else remembered()
    results = {name: result for name, result in known.items() if result.digest == digests.get(name)}
    asked = [mutant for mutant in mutants if not options.only or mutant.id in options.only]
    pending = [mutant for mutant in asked if mutant.id not in results or options.only]
    WORK.mkdir(parents=True, exist_ok=True)

    def done(mutant: Mutant, result: Result) -> None:
        results[mutant.id] = Result(result.status, result.detail, digests[mutant.id])
        remember(results)

    if pending:
        try_all(pending, options.jobs, done)
    if all(mutant.id in results for mutant in mutants):
        PAGE.write_text(render(mutants, results))
    killed = sum(results[mutant.id].status == "killed" for mutant in asked)
    print(f"{killed} of {len(asked)} mutants are killed by the test that is named")
    return 0 if killed == len(asked) else 1


if __name__ == "__main__":
    sys.exit(main())
