"""A full disk: a one-line error and no incomplete files. Simulated by a limit on file sizes."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command_result import CommandResult

resource = pytest.importorskip("resource", reason="limits of processes are POSIX's")
WITH_EXTRAS = all(importlib.util.find_spec(name) for name in ("optuna", "gtsam", "casadi"))
COMMANDS = {
    "plot": ("race", "oval", "--laps", "1", "--plot", "out.png"),
    "explain": ("explain", "oval", "--at", "5", "--plot", "out.png"),
    "compare": ("compare", "oval", "--drivers", "gap,pid", "--laps", "1", "--seeds", "1", "--report", "out.md"),
    "compare-html": ("compare", "oval", "--drivers", "gap", "--laps", "1", "--seeds", "1", "--report", "out.html"),
    "map": ("map", "oval", "--output", "out.yaml"),
    "line": ("line", "oval", "--output", "out.csv"),
    "tune": ("tune", "oval", "--budget", "2", "--no-validate", "--seeds", "1", "--starts", "none", "--out", "out"),
    "global": ("race", "oval", "--driver", "global", "--laps", "1"),
}
NEED_EXTRAS = ("map", "line", "tune", "global")


def without_room(folder: Path, most: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs a command with a limit on the size of files [bytes]."""
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({most}, {most}))"
    script = f"{limit}\nfrom firstlap_command import main; main()"
    return subprocess.run(
        [sys.executable, "-c", script, *arguments],
        cwd=folder,
        env={
            "PATH": "/usr/bin:/bin",
            "HOME": str(folder),
            "FIRSTLAP_CACHE": str(folder / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",  # otherwise Python keeps truncated bytecode files
        },
        capture_output=True,
        text=True,
        check=False,
    )


@contextmanager
def little_room(most: int) -> Iterator[None]:
    """Limits the size of files that this process may write [bytes]."""
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


def assert_one_line_and_nothing_half_written(folder: Path, most: int, code: int, err: str) -> None:
    output = [line for line in err.splitlines() if line.startswith("error:")]
    assert code == 2, err
    assert len(output) == 1, err
    assert "cannot be written" in output[0] or "cannot be made" in output[0]
    assert "Traceback" not in err
    whole = [file for file in folder.rglob("*") if file.is_file() and "matplotlib" not in str(file)]
    assert [file.name for file in whole if file.suffix != ".db" and file.stat().st_size >= most] == []
    assert not [file for file in whole if file.name.startswith(".")]


@pytest.mark.parametrize(("name", "most"), [*((name, 3000) for name in COMMANDS), ("plot", 0), ("tune", 0)])
def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(
    cli: Callable[..., CommandResult], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, most: int
) -> None:
    if name in NEED_EXTRAS and not WITH_EXTRAS:
        pytest.skip("the extras 'global' and 'tune' are not installed")
    import matplotlib.pyplot  # noqa: F401  # it has its list of fonts before there is no room for one

    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # otherwise Python keeps truncated bytecode files
    monkeypatch.setenv("FIRSTLAP_CACHE", str(tmp_path / "cache"))
    with little_room(most):
        ran = cli(*COMMANDS[name])
    assert_one_line_and_nothing_half_written(tmp_path, most, ran.code, ran.err)


def test_a_full_disk_is_one_line_of_a_whole_process(tmp_path: Path) -> None:
    done = without_room(tmp_path, 3000, *COMMANDS["plot"])
    assert_one_line_and_nothing_half_written(tmp_path, 3000, done.returncode, done.stderr)


@pytest.mark.parametrize("as_json", [False, True])
def test_a_picture_that_cannot_be_written_takes_no_result_with_it(tmp_path: Path, as_json: bool) -> None:
    done = without_room(tmp_path, 3000, *COMMANDS["plot"], *(["--json"] if as_json else []))
    assert_one_line_and_nothing_half_written(tmp_path, 3000, done.returncode, done.stderr)
    assert ('"outcome": "finished"' if as_json else "standing start") in done.stdout
    assert "plot: " not in done.stdout


def test_a_log_ends_where_the_disk_was_full_and_can_be_replayed_so_far(tmp_path: Path) -> None:
    done = without_room(tmp_path, 400_000, "race", "arena", "--laps", "3", "--record", "race.mcap")
    assert done.returncode == 2
    assert done.stderr == "error: race.mcap: cannot be written (File too large); the log ends there\n"
    assert without_room(tmp_path, 1_000_000, "replay", "race.mcap").returncode == 0


def test_a_result_that_standard_output_does_not_take_is_one_line(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-c", "from firstlap_command import main; main()", "tracks", "oval", "--json"],
            cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "error: output: No space left on device\n")
