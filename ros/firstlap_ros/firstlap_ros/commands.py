"""What `ros2 run firstlap_ros ...` starts: the commands of firstlap."""

import sys


def _run(command: str) -> None:
    from firstlap.cli import run

    sys.exit(run([command, *sys.argv[1:]]))


def drive() -> None:
    """The driving node, which waits for a person."""
    _run("drive")


def sim() -> None:
    """The simulator node."""
    _run("sim")


def preflight() -> None:
    """Looks at the live topics."""
    _run("preflight")
