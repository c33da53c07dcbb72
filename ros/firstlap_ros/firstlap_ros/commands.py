"""Entry points of `ros2 run firstlap_ros ...`: the commands of firstlap."""

import sys


def _run(command: str) -> None:
    from firstlap.cli import run

    sys.exit(run([command, *sys.argv[1:]]))


def drive() -> None:
    """Runs the driving node, which waits for consent."""
    _run("drive")


def sim() -> None:
    """Runs the simulator node."""
    _run("sim")


def preflight() -> None:
    """Checks the live topics."""
    _run("preflight")
