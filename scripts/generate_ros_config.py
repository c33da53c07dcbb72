"""Writes ros/firstlap_ros/config from the setups: every parameter of each as a ROS 2 parameter file.

With --check: compares only.
"""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

from firstlap.config.setup_file import list_setups, load_setup

FOLDER = Path(__file__).resolve().parents[1] / "ros" / "firstlap_ros" / "config"


def parameter_file(name: str) -> str:
    """The text of one file."""
    setup = load_setup(name)
    parameters = {"driver": setup.driver, **setup.values()}
    text = yaml.safe_dump({"/**": {"ros__parameters": parameters}}, sort_keys=False, default_flow_style=False)
    return f"# Written by scripts/generate_ros_config.py from setups/{name}.yaml. Do not edit.\n{text}"


def main(check: bool) -> int:
    """Exit code: 1 where a file is not what it should be."""
    wanted = {f"{name}.yaml": parameter_file(name) for name in list_setups()}
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
