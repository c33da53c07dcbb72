"""Writes ros/firstlap_ros/config: a ROS 2 parameter file for each setup, which names it and repeats none of its values.

Not for setups of a driver that needs a map: the driving node has none. With --check: compares only.
"""

from __future__ import annotations

import sys
from pathlib import Path

from firstlap.config.setup_file import list_setups, load_setup
from firstlap.drivers import DRIVERS

FOLDER = Path(__file__).resolve().parents[1] / "ros" / "firstlap_ros" / "config"
TEXT = """\
# Written by scripts/generate_ros_config.py. Do not edit: copy it, and add what differs on your car.
# The driving node takes every other parameter from setups/{name}.yaml, and what that does not set from its defaults.
# All parameters: docs/parameters.md, `ros2 param list`, `ros2 param describe`. A check: firstlap check {name}.
/**:
  ros__parameters:
    setup: {name}
"""


def names() -> list[str]:
    """The setups that the driving node can drive."""
    return [name for name in list_setups() if not DRIVERS[load_setup(name).driver].needs_map]


def parameter_file(name: str) -> str:
    """The text of the parameter file of one setup."""
    return TEXT.format(name=name)


def main(check: bool) -> int:
    """Writes or, with --check, compares. Exit code 1 if a file is out of date."""
    wanted = {f"{name}.yaml": parameter_file(name) for name in names()}
    there = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.yaml")}
    if wanted == there:
        return 0
    if check:
        differing = sorted(name for name in {*wanted, *there} if wanted.get(name) != there.get(name))
        print(f"ros/firstlap_ros/config: {', '.join(differing)}: run scripts/generate_ros_config.py", file=sys.stderr)
        return 1
    for name in there.keys() - wanted.keys():
        (FOLDER / name).unlink()
    for name, text in wanted.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv))
