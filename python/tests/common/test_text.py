"""Formatting of text for output."""

from __future__ import annotations

import pytest

from firstlap.common.text import counted, short_name, short_names, signed, to_side


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("arena", "arena"),
        ("random:7", "random:7"),
        ("maps/icra2022.yaml", "icra2022"),
        ("icra2022.yaml", "icra2022"),
        ("/logs/2026/evening.mcap", "evening"),
        ("/logs/rosbag2", "rosbag2"),
        ("[b]a[/b] 1/2", "[b]a[/b] 1/2"),
    ],
)
def test_of_a_path_the_files_name_is_shown(name: str, short: str):
    assert short_name(name) == short


def test_two_files_of_one_name_keep_their_folders():
    names = ["a/map.yaml", "b/map.yaml", "b/other.yaml", "arena"]
    assert list(short_names(names).values()) == ["a/map.yaml", "b/map.yaml", "other", "arena"]


def test_one_is_no_plural():
    assert [counted(number, "seed") for number in (0, 1, 2)] == ["0 seeds", "1 seed", "2 seeds"]


def test_nothing_has_no_minus():
    assert [signed(value, 2) for value in (-0.001, 0.0, 0.001, -0.006)] == ["+0.00", "+0.00", "+0.00", "-0.01"]
    assert signed(-0.04, 1, 6) == "  +0.0"


@pytest.mark.parametrize(
    ("value", "spec", "text"), [(0.27, "g", "0.27 m ahead"), (-0.1, ".2f", "0.10 m behind"), (0.0, "g", "0 m ahead")]
)
def test_a_distance_has_a_side_and_no_sign(value: float, spec: str, text: str) -> None:
    assert to_side(value, "ahead", "behind", spec) == text
