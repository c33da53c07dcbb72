"""The ROS 2 packages in the checkout, as far as they can be checked without colcon."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

import firstlap
from firstlap.common.errors import InputError
from firstlap.config.setup_file import load_setup
from firstlap.drivers.driving import Driving
from firstlap.ros import require_ros
from firstlap.ros.trace_message import topics_of

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "ros" / "firstlap_ros"
NODES = Path(firstlap.__file__).parent / "ros"
LAUNCHES = sorted((PACKAGE / "launch").glob("*.launch.py"))


def test_ros_is_here_for_the_tests_over_dds() -> None:
    try:
        require_ros()
    except InputError as missing:
        pytest.skip(str(missing))


def imported(path: Path) -> set[str]:
    """Top-level packages that a file imports."""
    tree = ast.parse(path.read_text())
    names = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    return {name.partition(".")[0] for name in names}


def test_the_parameter_files_are_what_the_setups_say() -> None:
    found = subprocess.run(
        [sys.executable, ROOT / "scripts" / "generate_ros_config.py", "--check"], capture_output=True, text=True
    )
    assert found.returncode == 0, found.stderr


@pytest.mark.parametrize("name", sorted(path.stem for path in (PACKAGE / "config").glob("*.yaml")))
def test_a_parameter_file_gives_its_setup_and_repeats_nothing_that_the_node_has_anyway(name: str) -> None:
    parameters = yaml.safe_load((PACKAGE / "config" / f"{name}.yaml").read_text())["/**"]["ros__parameters"]
    driving = Driving.of(parameters.pop("driver", ""), parameters.pop("setup", ""))
    assert driving.setup == load_setup(name)
    assert not parameters


def test_the_package_depends_on_every_ros_module_that_is_imported() -> None:
    depends = {one.text for one in ElementTree.parse(PACKAGE / "package.xml").iter("exec_depend")}
    files = [*NODES.glob("*.py"), *LAUNCHES]
    used = {name for path in files for name in imported(path)}
    ros = {
        name for name in used if name.endswith(("_msgs", "_srvs", "_interfaces")) or name.startswith(("rcl", "launch"))
    }
    assert ros <= depends
    assert len(ros) > 8


@pytest.mark.parametrize("folder", ["firstlap_ros", "ackermann_msgs", "tf2_msgs"])
def test_a_package_xml_is_valid(folder: str) -> None:
    package = pytest.importorskip("catkin_pkg.package", reason="catkin_pkg comes with `make ros`")
    found = package.parse_package(str(ROOT / "ros" / folder))
    found.validate()
    assert found.name == folder


@pytest.mark.parametrize("folder", ["ackermann_msgs", "tf2_msgs"])
def test_colcon_leaves_the_generated_messages_to_apt(folder: str) -> None:
    assert (ROOT / "ros" / folder / "COLCON_IGNORE").exists()


def test_versions_agree() -> None:
    assert ElementTree.parse(PACKAGE / "package.xml").findtext("version") == firstlap.__version__
    assert f'version="{firstlap.__version__}"' in (PACKAGE / "setup.py").read_text()


@pytest.mark.parametrize("path", LAUNCHES, ids=lambda path: path.name)
def test_a_launch_file_names_executables_files_and_launch_files_that_exist(path: Path) -> None:
    tree = ast.parse(path.read_text())
    assert any(isinstance(node, ast.FunctionDef) and node.name == "generate_launch_description" for node in tree.body)
    executables = (PACKAGE / "setup.py").read_text()
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "executable":
            assert isinstance(node.value, ast.Constant)
            assert f'"{node.value.value} = ' in executables
        if isinstance(node, ast.Constant) and str(node.value).endswith(".yaml"):
            assert (PACKAGE / "config" / str(node.value)).exists()
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "include":
            assert isinstance(node.args[0], ast.Constant)
            assert (PACKAGE / "launch" / f"{node.args[0].value}.launch.py").exists()


def test_parameters_of_launch_files_are_parameters_of_the_nodes() -> None:
    from firstlap.ros.names import DRIVE, SIM

    known = {entry.name for entry in (*DRIVE, *SIM)} | {"use_sim_time"}
    for path in LAUNCHES:
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict):
                rows = zip(node.value.keys, node.value.values, strict=True)
                typed = {
                    key.value
                    for key, row in rows
                    if isinstance(key, ast.Constant) and isinstance(row, ast.Tuple) and len(row.elts) == 3
                }
                assert typed <= known


def test_the_layouts_show_the_topics_that_the_nodes_have() -> None:
    layout = json.loads((PACKAGE / "foxglove" / "firstlap.json").read_text())
    panels: set[str] = set()

    def walk(part: object) -> None:
        if isinstance(part, str):
            panels.add(part)
        elif isinstance(part, dict):
            walk(part["first"])
            walk(part["second"])

    walk(layout["layout"])
    assert panels == set(layout["configById"])
    rviz = yaml.safe_load((PACKAGE / "rviz" / "firstlap.rviz").read_text())
    topics = {one.get("Topic", {}).get("Value") for one in rviz["Visualization Manager"]["Displays"]}
    assert {"/scan", "/odom", "/firstlap_drive/markers"} <= topics
    under = "/firstlap_drive/trace/"
    shown = [topic for topic in (*topics, *layout["configById"]["3D!scene"]["topics"]) if topic and under in topic]
    assert len(shown) > 4
    assert {topic.removeprefix(under) for topic in shown} <= topics_of("local").keys()
