"""What `ros2 run firstlap_ros ...` starts: the commands of firstlap. The driving node waits to be activated."""

import sys


def _run(command: str, *arguments: str) -> None:
    from firstlap.cli import run

    sys.exit(run([command, *arguments, *sys.argv[1:]]))


def drive() -> None:
    """The driving node; --start drives as soon as scan and odometry are there."""
    _run("drive", *(() if "--start" in sys.argv else ("--no-start",)))


def sim() -> None:
    """The simulator node."""
    _run("sim")


def preflight() -> None:
    """Looks at the live topics."""
    _run("preflight")
