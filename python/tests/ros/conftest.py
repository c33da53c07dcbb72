"""Real nodes in real processes over DDS, one ROS_DOMAIN_ID each."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from running import Running
from waiting import PATIENCE

from firstlap.common.errors import InputError
from firstlap.ros import require_ros
from firstlap.ros.domains import own_domain

try:
    require_ros()
except InputError as missing:
    collect_ignore_glob = ["test_dds_*.py"]
    REASON: str | None = str(missing)
else:
    REASON = None

LIMIT = 0.3
"""[s] Maximum time from a fault to the stop command."""
SETS_OFF = 0.25
"""[s] Time from consent to the first motion command, before consent is repeated."""
SILENT = 0.5
"""[s] Time without a command that counts as silence."""


FAST = 20.0
"""[m/s] Speed limit of the simulated car."""


def split(arguments: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Splits arguments into those of the command and ROS arguments."""
    at = arguments.index("--ros-args") if "--ros-args" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1 :]


class Lab:
    """Processes in one domain, and a probe node."""

    sim: Running
    drive: Running

    def __init__(self, folder: Path, domain: int) -> None:
        from probe import Probe

        self.folder = folder
        self.domain = domain
        self.running: list[Running] = []
        self.probe = Probe(self.domain)

    def start(self, *arguments: str) -> Running:
        """Runs a firstlap command."""
        self.running.append(Running(self.folder, self.domain, *arguments))
        return self.running[-1]

    def start_sim(self, *arguments: str) -> None:
        """Starts the shared simulator, or replaces it."""
        self.sim = self.start("sim", *(arguments or ("arena",)))

    def start_drive(self, *arguments: str) -> None:
        """Starts the shared driving node, or replaces it: with consent in advance and a high speed limit."""
        ours, ros = split(arguments)
        self.drive = self.start("drive", "--go", *ours, "--ros-args", "-p", f"speed_limit:={FAST}", *ros)

    def well(self) -> None:
        """Restores the state for the next test: both nodes run, the driver is active, and the car moves."""
        for one in (self.sim, self.drive):
            one.send(signal.SIGCONT)
        if self.sim.over:
            self.start_sim()
        if self.drive.over:
            self.start_drive()
        if not self.probe.moves():
            self.probe.trigger("/reset")  # the car may be at a wall after the previous test
        self.resume()

    def until(self, condition: Callable[[], Any], what: str | Callable[[], str], seconds: float = PATIENCE) -> Any:
        """Spins the probe until a condition holds; fails with what it waited for and the output of all processes."""
        deadline = time.monotonic() + seconds
        while not (found := condition()):
            if time.monotonic() > deadline:
                waited = what if isinstance(what, str) else what()
                raise AssertionError(f"never: {waited}\n" + "\n".join(one.output[-3000:] for one in self.running))
            self.probe.spin(0.01)
        return found

    def driving(self, drive: str = "/drive", faster_than: float = 0.5) -> None:
        """Waits until the car is commanded to move."""
        self.until(lambda: self.probe.speed(drive) > faster_than, f"{drive} moves")

    def resume(self, drive: str = "/drive", node: str = "/firstlap_drive") -> None:
        """Gives consent until the car moves: on a busy machine it may stop again immediately."""

        def moves() -> bool:
            heard = self.probe.commands[drive]
            if not self.probe.moves(drive) and (not heard or heard[-1].speed == 0.0 or self.silent(drive)):
                self.probe.trigger(f"{node}/go")
                asked = time.monotonic()
                while not self.probe.moves(drive) and time.monotonic() - asked < SETS_OFF:
                    self.probe.spin(0.02)
            return self.probe.moves(drive)

        self.until(moves, f"{drive} moves again")

    def goes_on(self, *spaces: str) -> None:
        """Repeats consent after stops caused by a busy machine, while waiting for a condition."""
        for space in spaces or ("",):
            heard = self.probe.commands[f"{space}/drive"]
            # After a node died while driving, its last command remains, and the next node waits for consent.
            if heard and (heard[-1].speed == 0.0 or self.silent(f"{space}/drive")):
                self.probe.trigger(f"{space}/firstlap_drive/go")
        self.probe.spin(0.05)

    def driven(self, condition: Callable[[], Any], what: str, *spaces: str, seconds: float = PATIENCE) -> Any:
        """Waits as `until`, while cars are kept driving."""
        return self.until(lambda: (self.goes_on(*spaces), condition())[1], what, seconds)

    def silent(self, drive: str = "/drive") -> bool:
        """Whether no command has arrived for a while."""
        heard = self.probe.commands[drive]
        return not heard or time.monotonic() - heard[-1].time > SILENT

    def waits(self) -> dict[str, int]:
        """Run-queue wait time [ns] of each thread of the nodes and the probe."""
        found = {}
        for process in (os.getpid(), *(one.process.pid for one in self.running if not one.over)):
            for file in Path(f"/proc/{process}/task").glob("*/schedstat"):
                with suppress(OSError):
                    found[file.parent.name] = int(file.read_text().split()[1])
        return found

    def kept_since(self, before: dict[str, int]) -> float:
        """Upper bound of the run-queue wait time [s] since then; threads may have waited simultaneously."""
        return 1e-9 * sum(wait - before.get(thread, 0) for thread, wait in self.waits().items())

    def stops_in_time(self, fault: Callable[[], object], drive: str = "/drive", known: bool = False) -> None:
        """Injects a fault; a stop must be commanded within LIMIT plus the run-queue wait time. known: the fault is
        effective when `fault` starts, not when it returns."""
        heard = self.probe.commands[drive]
        waits, since = self.waits(), time.monotonic()
        fault()
        since = since if known else time.monotonic()

        def stop() -> float | None:
            return next((one.time for one in heard if one.time >= since and one.speed == 0.0), None)

        late = self.until(stop, "a stop") - since
        kept = self.kept_since(waits)
        assert late <= LIMIT + kept, f"stopped after {late:.3f} s, of which the machine took at most {kept:.3f} s"

    def stays_stopped(self, commands: int, drive: str = "/drive") -> None:
        """Waits for a number of further commands, all of which must be stops."""
        heard = self.probe.commands[drive]
        before = len(heard)
        self.until(lambda: len(heard) >= before + commands, "more stops")
        assert {one.speed for one in heard[before:]} == {0.0}

    def close(self) -> None:
        """Ends all processes."""
        for one in reversed(self.running):
            one.end()
        self.probe.close()


def _lab(folder: Path) -> Iterator[Lab]:
    if REASON:
        pytest.skip(REASON)
    with pytest.MonkeyPatch.context() as patch, own_domain() as domain:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SYSTEM_DEFAULT")  # as in the profile
        patch.setenv("FASTDDS_DEFAULT_PROFILES_FILE", str(Path(__file__).with_name("loopback.xml")))
        lab = Lab(folder, domain)
        try:
            yield lab
        finally:
            lab.close()


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    """A domain of its own for one test."""
    yield from _lab(tmp_path)


@pytest.fixture(scope="session")
def lab_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Iterator[Lab]]:
    """Makes a lab for the tests of one file."""
    return lambda name: _lab(tmp_path_factory.mktemp(name))


@pytest.fixture(scope="session")
def lapping_lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """A lab with a driving car, for all tests that restore this state."""
    for lab in _lab(tmp_path_factory.mktemp("lab")):
        lab.start_sim()
        lab.start_drive()
        lab.well()
        yield lab


@pytest.fixture
def shared_lab(lapping_lab: Lab) -> Lab:
    """The driving car, restored after the previous test."""
    lapping_lab.well()
    return lapping_lab
