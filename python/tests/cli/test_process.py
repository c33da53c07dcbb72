"""The command in a separate process: Ctrl-C at any time, closed pipes, ASCII-only terminals."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from waiting import PATIENCE

pytestmark = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="reads /proc of the processes it starts")


def start(folder: Path, *arguments: str, first: str = "") -> subprocess.Popen[str]:
    """Starts the command like its console script, after the line `first`."""
    script = f"{first}\nfrom firstlap_command import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", script, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    )


def wait_for_library(process: subprocess.Popen[str], name: str) -> None:
    """Waits until the process has loaded a shared library of this name."""
    deadline = time.monotonic() + PATIENCE
    while name not in Path(f"/proc/{process.pid}/maps").read_text():
        assert process.poll() is None, "ended too early"
        assert time.monotonic() < deadline
        time.sleep(0.002)


def interrupted(process: subprocess.Popen[str]) -> str:
    """Sends Ctrl-C and checks the result; returns standard output."""
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert err.startswith("error: interrupted")
    assert err.count("\n") == 1
    return out


@pytest.mark.parametrize("library", ["_multiarray_umath", "libgeos"])
def test_ctrl_c_during_the_imports_is_one_line(tmp_path: Path, library: str) -> None:
    process = start(tmp_path, "race", "oval")
    wait_for_library(process, library)
    interrupted(process)


def test_ctrl_c_that_a_nohup_ignores_stays_ignored(tmp_path: Path) -> None:
    process = start(tmp_path, "check", "base", first="import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)")
    wait_for_library(process, "_multiarray_umath")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 0


FORKS = """
import json, os, signal, sys, time
from firstlap.cli import main
codes = []
for target, unbuffered, arguments in json.loads(sys.argv[1]):
    child = os.fork()
    if child == 0:
        reader, writer = os.pipe()
        os.close(reader)
        os.dup2(writer if target == "gone" else os.open(target, os.O_WRONLY), 1)
        sys.stdout.reconfigure(write_through=unbuffered)
        sys.argv = ["firstlap", *arguments]
        main()
    if target == "/dev/null":
        time.sleep(0.3)
        os.kill(child, signal.SIGINT)
    codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
print(json.dumps(codes))
"""
"""Runs commands in forked processes, after importing everything once. Standard output goes to a file or a closed pipe;
commands that write to /dev/null are interrupted after a moment."""


def forked(folder: Path, *commands: tuple[str, bool, tuple[str, ...]]) -> tuple[list[int], str]:
    """Exit codes of (target, unbuffered, arguments), and their joint standard error."""
    done = subprocess.run(
        [sys.executable, "-c", FORKS, json.dumps(commands)], capture_output=True, text=True, check=True, cwd=folder
    )
    return json.loads(done.stdout), done.stderr


def test_ctrl_c_while_it_works_is_one_line_and_leaves_no_file(tmp_path: Path) -> None:
    commands = (
        ("race", "oval", "--laps", "100000"),
        ("survey", "all", "--seeds", "1000", "--laps", "100"),
        ("explain", "oval", "--at", "2900"),
        ("bench", "arena"),
    )
    codes, output = forked(tmp_path, *(("/dev/null", False, command) for command in commands))
    assert codes == [130] * len(commands), output
    assert re.fullmatch(r"(error: interrupted.*\n){4}", output)
    assert not list(tmp_path.iterdir())


def test_a_reader_that_has_gone_ends_every_command_quietly_with_141(tmp_path: Path) -> None:
    commands = (
        ("check", "base", "--json"),
        ("race", "oval", "--laps", "1"),
        ("survey", "oval", "--laps", "1", "--seeds", "1", "--json"),
        ("--help",),
    )
    both = [("gone", unbuffered, command) for command in commands for unbuffered in (False, True)]
    assert forked(tmp_path, *both) == ([141] * len(both), "")


def test_a_full_disk_is_one_line(tmp_path: Path) -> None:
    codes, output = forked(tmp_path, *(("/dev/full", unbuffered, ("check", "base")) for unbuffered in (False, True)))
    assert codes == [2, 2]
    assert output == 2 * "error: output: No space left on device\n"


def test_a_terminal_that_knows_ascii_only_gets_readable_text(tmp_path: Path) -> None:
    commands = [
        ["race", "oval", "--laps", "1"],
        ["survey", "oval", "--laps", "1", "--seeds", "1"],
        ["check", "race"],
        ["tracks"],
        ["explain", "oval", "--plot", str(tmp_path / "a.png")],
        ["--help"],
        ["race", "k\u00fcche.yaml"],
    ]
    script = "import json, sys, firstlap.cli.process as p, firstlap.cli as c; p.watch_process()\n"
    script += "print([c.run(arguments) for arguments in json.loads(sys.argv[1])])"
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""}
    done = subprocess.run(
        [sys.executable, "-c", script, json.dumps(commands)], capture_output=True, env=environment, check=False
    )
    out, err = done.stdout.decode("ascii"), done.stderr.decode("ascii")
    assert "[0, 0, 0, 0, 0, 0, 2]" in out, err
    assert " us (p50)" in out
    assert "| lap | time s |" in out
    assert "kuche.yaml" in err


@pytest.mark.parametrize("closed", ["2>&-", "2>/dev/full", "2>&- <&-"])
def test_who_does_not_listen_to_remarks_changes_nothing(tmp_path: Path, closed: str) -> None:
    """The race writes a log, which must not get the output for stderr."""
    (tmp_path / "ring.csv").write_text(
        "\n".join(f"{30 * math.cos(a / 20)},{30 * math.sin(a / 20)},6,6" for a in range(126))
    )
    command = f"{sys.executable} -c 'from firstlap_command import main; main()'"
    arguments = "race ring.csv --laps 1 --json --record race.mcap"
    done = subprocess.run(
        ["sh", "-c", f"{command} {arguments} {closed}"], cwd=tmp_path, stdout=subprocess.PIPE, check=False
    )
    assert done.returncode == 0
    assert json.loads(done.stdout)["outcome"] == "finished"
    replayed = subprocess.run(
        ["sh", "-c", f"{command} replay race.mcap --json"], cwd=tmp_path, capture_output=True, check=False
    )
    assert replayed.returncode == 0, replayed.stderr


def test_two_logs_in_one_file_are_refused(tmp_path: Path) -> None:
    first = start(tmp_path, "race", "arena", "--laps", "100000", "--record", "race.mcap")
    deadline = time.monotonic() + PATIENCE
    while not (tmp_path / "race.mcap").exists() or not (tmp_path / "race.mcap").stat().st_size:
        assert first.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)
    second = start(tmp_path, "race", "oval", "--laps", "1", "--record", "race.mcap")
    _, output = second.communicate(timeout=PATIENCE)
    assert second.returncode == 2
    assert output == "error: race.mcap: is being written by another process; expected another file name\n"
    first.kill()
    first.communicate(timeout=PATIENCE)
    # The lock was released with its process.
    third = start(tmp_path, "race", "oval", "--laps", "1", "--record", "race.mcap")
    third.communicate(timeout=PATIENCE)
    assert third.returncode == 0
