"""docs/architecture.md agrees with the build."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/architecture.md").read_text()
CORE = ROOT / "cpp/firstlap"
CORE_TABLE, PYTHON_TABLE = PAGE.split("The Python package mirrors")
PYTHON_TABLE = PYTHON_TABLE.split("## Where to find it")[0]


def test_the_table_of_layers_holds_the_dependencies_of_the_cmake_targets() -> None:
    calls = re.findall(r"^firstlap_layer\(([a-z ]+)\)", (ROOT / "cpp/CMakeLists.txt").read_text(), re.MULTILINE)
    targets = {name: set(needs) for name, *needs in map(str.split, calls)}
    rows = re.findall(r"^\| `(\w+)` \| ([a-z, ]*) ?\|", CORE_TABLE, re.MULTILINE)
    table = {name: {need.strip() for need in needs.split(",") if need.strip()} for name, needs in rows}
    assert {name: table.get(name) for name in targets} == targets


def test_every_folder_of_the_core_is_a_layer_of_the_table() -> None:
    rows = set(re.findall(r"^\| `(\w+)` \|", CORE_TABLE, re.MULTILINE))
    assert {folder.name for folder in CORE.iterdir()} <= rows


def test_every_module_in_the_diagram_is_a_file_of_its_layer() -> None:
    diagram = re.search(r"```mermaid\n(.*?)```", PAGE, re.DOTALL)
    assert diagram
    subgraphs = re.findall(r"subgraph (\w+)\n(.*?)\n  end", diagram.group(1), re.DOTALL)
    assert {layer for layer, _ in subgraphs} >= {"perception", "planning", "control"}
    for layer, body in subgraphs:
        shown = ", ".join(re.findall(r"\w+\[([^\]]+)\]", body)).split(", ")
        shown += [word for word in re.findall(r"\w+", re.sub(r"\w+\[[^\]]+\]", "", body)) if len(word) > 6]
        missing = [name for name in shown if not (CORE / layer / f"{name}.hpp").is_file()]
        assert not missing, (layer, missing)


def test_the_table_of_packages_has_the_order_that_the_import_linter_checks() -> None:
    layers = re.search(r"exhaustive = true\nlayers = \[(.*?)\]", (ROOT / "pyproject.toml").read_text(), re.DOTALL)
    assert layers
    rows = re.findall(r"^\| `(\w+)` \|", PYTHON_TABLE, re.MULTILINE)
    assert rows[::-1] == re.findall(r'"(\w+)"', layers.group(1))


def test_every_linked_page_and_every_named_path_exists() -> None:
    links = [f"docs/{target}" for target in re.findall(r"\]\(([^):#]+)\)", PAGE)]
    paths = re.findall(r"`((?:cpp|python|docs|examples|setups)/[\w./]*)`", PAGE)
    assert paths
    assert not [path for path in [*links, *paths] if not (ROOT / path).exists()]
