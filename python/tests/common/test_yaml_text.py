"""Untrusted YAML: whatever PyYAML raises, is slow at, or silently drops becomes a one-line error."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import MAX_NODES, MAX_SCALAR, parse_mapping

QUICK = 8.0
"""[s] CPU time limit, for input that took minutes before."""
TAGS = (
    "float",
    "int",
    "bool",
    "timestamp",
    "binary",
    "null",
    "set",
    "omap",
    "pairs",
    "map",
    "seq",
    "str",
    "python/none",
)


@pytest.mark.parametrize("tag", TAGS)
@pytest.mark.parametrize("value", ['"_"', '""', '"x"', '"-"', "[1]", "{a: 1}", '"1:"', '"0x"', '"0b"', "~"])
def test_a_tag_that_does_not_fit_its_value_is_one_line(tag: str, value: str) -> None:
    try:
        data = parse_mapping(f"key: !!{tag} {value}\n", "file.yaml")
    except InputError as error:
        assert str(error).startswith("file.yaml")
    else:
        assert set(data) == {"key"}


@pytest.mark.parametrize("value", ['!!float "_"', '!!int "_"', '!!int ""', "0x" + "f" * 2900, "1" + ":1" * 1400])
@pytest.mark.parametrize(
    ("name", "text", "command"),
    [
        ("setup.yaml", "stanley:\n  k_ang: {}\n", ("check", "setup.yaml")),
        ("car.yaml", "vehicle:\n  friction: {}\n", ("check", "base", "--car", "car.yaml")),
        ("track.yaml", "centerline: [[{}, 0, 1, 1], [9, 0, 1, 1], [9, 9, 1, 1]]\n", ("tracks", "track.yaml")),
        ("map.yaml", "image: a.png\nresolution: {}\norigin: [0, 0, 0]\n", ("tracks", "map.yaml")),
    ],
    ids=["setup", "car", "track", "map"],
)
def test_a_value_that_is_no_number_is_refused_in_one_line(cli, name: str, text: str, command, value: str) -> None:
    Path(name).write_text(text.format(value))
    ran = cli(*command)
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1), ran.err
    assert name in ran.err


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: [" + "1," * (MAX_NODES + 1) + "1]", "values"),
        ("a:\n" + "- 1\n" * (MAX_NODES + 1), "values"),
        ("".join(f"k{i}: {i}\n" for i in range(60_000)), "values"),
        ("a: 1" + ":1" * 400_000, "characters"),
        ("a: '" + "x" * 900_000 + "'", "characters"),
        ("- " * 400_000, "nested"),
        ("[" * 400_000, "nested"),
        ("{a: " * 200_000, "nested"),
        ("".join(" " * i + f"k{i}:\n" for i in range(1000)), "nested"),
        ("a: &x 1\nb: *x\n", "aliases"),
        ("a: [{b: 1, b: 2}]\n", "given twice"),
        ("x" * 1_000_001, "1 MB"),
    ],
    ids=["flow", "block", "keys", "base-60", "text", "dashes", "brackets", "braces", "deep", "alias", "twice", "large"],
)
def test_what_takes_long_or_cannot_be_ours_is_refused_soon(text: str, says: str) -> None:
    began = time.process_time()
    with pytest.raises(InputError, match=says) as caught:
        parse_mapping(text, "file.yaml")
    assert time.process_time() - began < QUICK
    assert str(caught.value).startswith("file.yaml")


def test_what_is_within_the_bounds_is_read() -> None:
    assert parse_mapping("a: " + "x" * MAX_SCALAR, "f")["a"] == "x" * MAX_SCALAR
    assert len(parse_mapping("a: [" + "1," * 50_000 + "1]", "f")["a"]) == 50_001
    assert parse_mapping("a: {b: [1, 2.5, yes, text]}", "f") == {"a": {"b": [1, 2.5, True, "text"]}}
