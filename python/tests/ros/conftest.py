"""Real nodes in real processes over DDS, one ROS_DOMAIN_ID each."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from firstlap.errors import InputError
from firstlap.ros import require_ros

try:
    require_ros()
except InputError as missing:
    collect_ignore_glob = ["test_dds_*.py"]
    REASON: str | None = str(missing)
else:
    REASON = None

DOMAINS = itertools.count(os.getpid())
PATIENCE = 60.0
"""[s] until a condition counts as never met: the machine may be busy."""


class Running:
    """A command of ours as a process; its output goes to a file."""

    def __init__(self, folder: Path, domain: int, *arguments: str) -> None:
        self.log = folder / f"{arguments[0]}-{len(list(folder.iterdir()))}.log"
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "RCUTILS_COLORIZED_OUTPUT": "0"}
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-c", "from firstlap_command import main; main()", *arguments],
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=folder,
                env=environment,
            )

    @property
    def said(self) -> str:
        """Its output so far."""
        return self.log.read_text()

    def send(self, number: int) -> None:
        """A signal."""
        self.process.send_signal(number)

    def wait(self, seconds: float = PATIENCE) -> int:
        """Its exit code."""
        return self.process.wait(seconds)

    def end(self) -> None:
        """However it stands."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


class Lab:
    """Processes in one domain, and a probe that hears and speaks."""

    def __init__(self, folder: Path) -> None:
        from probe import Probe

        self.folder = folder
        self.domain = 1 + next(DOMAINS) % 100
        self.running: list[Running] = []
        self.probe = Probe(self.domain)

    def start(self, *arguments: str) -> Running:
        """Runs a command of ours."""
        self.running.append(Running(self.folder, self.domain, *arguments))
        return self.running[-1]

    def until(self, condition: Callable[[], Any], what: str, seconds: float = PATIENCE) -> Any:
        """Spins the probe until it holds; fails with what all processes said."""
        deadline = time.monotonic() + seconds
        while not (found := condition()):
            if time.monotonic() > deadline:
                raise AssertionError(f"never: {what}\n" + "\n".join(one.said[-3000:] for one in self.running))
            self.probe.spin(0.01)
        return found

    def driving(self, drive: str = "/drive", faster_than: float = 0.5) -> None:
        """Until the car is commanded to move."""
        self.until(lambda: self.probe.speed(drive) > faster_than, f"{drive} moves")

    def resume(self, drive: str = "/drive", node: str = "/firstlap_drive") -> None:
        """The driver's consent, until the car moves: a busy machine may stop it again at once."""

        def moves() -> bool:
            if self.probe.speed(drive) == 0.0:
                self.probe.trigger(f"{node}/resume")
                self.probe.spin(0.05)
            return self.probe.speed(drive) > 0.5

        self.until(moves, f"{drive} moves again")

    def close(self) -> None:
        """Ends everything."""
        for one in reversed(self.running):
            one.end()
        self.probe.close()


def _lab(folder: Path) -> Iterator[Lab]:
    if REASON:
        pytest.skip(REASON)
    before = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    lab = Lab(folder)
    try:
        yield lab
    finally:
        lab.close()
        if before is None:
            os.environ.pop("ROS_AUTOMATIC_DISCOVERY_RANGE")


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    """A domain of its own for one test."""
    yield from _lab(tmp_path)


@pytest.fixture(scope="module")
def shared_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """A domain for the tests of one file, with a car that laps."""
    for lab in _lab(tmp_path_factory.mktemp("lab")):
        lab.start("sim", "arena")
        lab.start("drive")
        lab.resume()
        yield lab
