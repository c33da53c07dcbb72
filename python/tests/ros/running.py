"""Runs firstlap commands in processes that are forked from one with all imports, so that they start fast."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from pathlib import Path
from typing import Any

from waiting import PATIENCE

FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    [
        *(
            "__main__",
            "running",
            "firstlap_command",
            "firstlap.cli.drive",
            "firstlap.cli.sim",
            "firstlap.cli.preflight",
            "firstlap.cli.remote",
        ),
        *("firstlap.ros.drive_node", "firstlap.ros.sim_node", "firstlap.ros.process"),
        *("firstlap.ros.preflight", "firstlap.ros.remote"),
    ]
)


def _command(arguments: tuple[str, ...], log: str, folder: str, environment: dict[str, str]) -> None:
    """Runs the command in the new process, like the console script."""
    os.environ.update(environment)
    os.chdir(folder)
    out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(out, 1)
    os.dup2(out, 2)
    sys.argv = ["firstlap", *arguments]
    from firstlap_command import main

    sys.exit(main())


class Running:
    """A running firstlap command; its output goes to a file."""

    def __init__(self, folder: Path, domain: int, *arguments: str) -> None:
        self.log = folder / f"{arguments[0]}-{len(list(folder.iterdir()))}.log"
        self.log.touch()
        environment = {
            name: value for name, value in os.environ.items() if name.startswith(("ROS_", "RMW_", "FASTDDS_"))
        }
        environment |= {"ROS_DOMAIN_ID": str(domain), "RCUTILS_COLORIZED_OUTPUT": "0", "COLUMNS": "200"}
        environment["XDG_RUNTIME_DIR"] = str(folder / "state")
        (folder / "state").mkdir(exist_ok=True)
        self.process: Any = FORKS.Process(
            target=_command, args=(arguments, str(self.log), str(folder), environment), daemon=True
        )
        self.process.start()

    @property
    def output(self) -> str:
        """Its output so far."""
        return self.log.read_text()

    @property
    def over(self) -> bool:
        """Whether the process has ended."""
        return self.process.exitcode is not None

    def send(self, number: int) -> None:
        """Sends a signal."""
        if not self.over:
            os.kill(self.process.pid, number)

    def wait(self, seconds: float = PATIENCE) -> int | None:
        """Waits for the exit code."""
        self.process.join(seconds)
        return self.process.exitcode

    def end(self) -> None:
        """Ends the process in any state."""
        self.send(signal.SIGCONT)
        self.send(signal.SIGTERM)
        if self.wait(10.0) is None:
            self.send(signal.SIGKILL)
            self.wait(10.0)
