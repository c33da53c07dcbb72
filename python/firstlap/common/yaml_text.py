"""Reads untrusted YAML within limits on size, depth and time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from firstlap.common.errors import InputError
from firstlap.common.files import check_readable

MAX_YAML_BYTES = 1_000_000
MAX_NODES = 110_000
"""Scalars, lists and mappings per file: a centerline of 20 000 points has 100 000. PyYAML takes 20 us for each."""
MAX_DEPTH = 20
"""Nesting depth of lists and mappings."""
MAX_SCALAR = 3_000
"""Characters per value. An integer of this length can still be printed, and read in base 60."""
SHOWN = 60
"""Maximum number of characters of a key in a message."""

LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's loader if PyYAML was built with it: five times as fast."""


def read_text(path: Path, expected: str = "a YAML file", largest: int = MAX_YAML_BYTES) -> str:
    """The text of a file. Raises InputError if it is missing, empty, larger than `largest` bytes or not UTF-8.

    expected: description of the file for messages.
    """
    try:
        check_readable(path, expected)
        if path.stat().st_size > largest:
            raise InputError(f"{path}: larger than {largest / 1e6:g} MB; expected {expected}")
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        hint = " (give the .yaml, not the image)" if path.suffix.lower() not in (".yaml", ".yml", ".csv") else ""
        raise InputError(f"{path}: not text; expected {expected}{hint}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from None
    if not text.strip():
        raise InputError(f"{path}: empty; expected {expected}")
    return text


def parse_mapping(text: str, where: str) -> dict[str, Any]:
    """The YAML mapping in `text`; `where` names the file in messages.

    Raises InputError if it is not a mapping, repeats a key, uses aliases (which can expand without limit), or exceeds
    `MAX_YAML_BYTES`, `MAX_NODES`, `MAX_DEPTH` or `MAX_SCALAR`.
    """
    if len(text) > MAX_YAML_BYTES:
        raise InputError(f"{where}: larger than 1 MB; expected a YAML file of a few lines")
    try:
        _refuse_brackets(text, where)
        _check_events(text, where)
        data = _construct(text, where)
    except InputError:
        raise
    except yaml.MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"{where}{line}: not YAML ({error.problem or error.context})") from None
    except Exception as error:  # PyYAML's constructors raise nearly anything for a tag that does not fit its value
        raise InputError(f"{where}: not YAML ({type(error).__name__}: {str(error)[:120]})") from None
    if not isinstance(data, dict):
        raise InputError(f"{where}: expected 'key: value' lines, found {type(data).__name__}")
    return data


def _refuse_brackets(text: str, where: str) -> None:
    """Raises InputError if brackets are nested deeper than `MAX_DEPTH`, for which PyYAML's scanner takes minutes."""
    depth = 0
    for character in text:
        depth += (character in "[{") - (character in "]}")
        if depth > MAX_DEPTH:
            raise InputError(f"{where}: brackets nested more than {MAX_DEPTH} deep; expected plain lists of numbers")


def _check_events(text: str, where: str) -> None:
    """Raises InputError if `MAX_NODES`, `MAX_DEPTH` or `MAX_SCALAR` is exceeded, or for aliases."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=LOADER)):
        if isinstance(event, yaml.AliasEvent):
            raise InputError(f"{where}: YAML aliases (*name) are not supported; write the values out")
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        line = event.start_mark.line + 1 if event.start_mark else 0
        if depth > MAX_DEPTH:
            raise InputError(f"{where}, line {line}: nested more than {MAX_DEPTH} deep; expected sections of values")
        if count > MAX_NODES:
            raise InputError(f"{where}: more than {MAX_NODES} values; expected a YAML file of a few lines")
        if isinstance(event, yaml.ScalarEvent) and len(event.value) > MAX_SCALAR:
            raise InputError(f"{where}, line {line}: a value of {len(event.value)} characters; at most {MAX_SCALAR}")


def _construct(text: str, where: str) -> Any:
    loader = LOADER(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        _refuse_duplicates(node, where)
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _refuse_duplicates(root: yaml.Node, where: str) -> None:
    """Raises InputError if a mapping repeats a key; YAML readers silently drop one of them."""
    for mapping in _mappings(root):
        seen: set[str] = set()
        for key, _ in mapping.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                line = key.start_mark.line + 1
                raise InputError(f"{where}, line {line}: '{key.value[:SHOWN]}' is given twice")
            seen.add(key.value)


def _mappings(root: yaml.Node) -> Iterator[yaml.MappingNode]:
    pending = [root]
    while pending:
        node = pending.pop()
        if isinstance(node, yaml.MappingNode):
            yield node
            pending += [value for _, value in node.value]
        elif isinstance(node, yaml.SequenceNode):
            pending += node.value
