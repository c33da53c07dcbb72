"""Of two driving nodes on one topic one yields, from any initial state."""

from __future__ import annotations

import itertools

import pytest

from firstlap.ros.claims import LASTS, Claim, Claims, decode


def pair() -> tuple[Claims, Claims]:
    """The claims of the first and the second node."""
    return Claims(1, "/a"), Claims(2, "/b")


def test_a_node_alone_may_drive_whatever_it_says_itself() -> None:
    alone = Claims(1, "/a")
    alone.add(alone.own(True).encode(), 0.0)
    assert alone.reason(False, 0.0) == alone.reason(True, 0.0) == ""


def test_of_two_that_wait_the_second_gives_way_and_names_the_first() -> None:
    first, second = pair()
    first.add(second.own(False).encode(), 0.0)
    second.add(first.own(False).encode(), 0.0)
    assert first.reason(False, 0.1) == ""
    assert second.reason(False, 0.1) == "another driving node started first: /a; stop one of them"


def test_the_one_that_drives_has_precedence_over_one_that_was_born_before() -> None:
    first, second = pair()
    first.add(second.own(True).encode(), 0.0)
    second.add(first.own(False).encode(), 0.0)
    assert second.reason(True, 0.1) == "", "a node that only waits does not stop a car"
    assert first.reason(False, 0.1) == "another driving node drives: /b; stop one of them"


@pytest.mark.parametrize(("a", "b"), list(itertools.product([False, True], repeat=2)))
def test_never_do_both_drive_once_they_have_heard_each_other(a: bool, b: bool) -> None:
    first, second = pair()
    first.add(second.own(b).encode(), 0.0)
    second.add(first.own(a).encode(), 0.0)
    assert bool(first.reason(a, 0.1)) != bool(second.reason(b, 0.1))


def test_born_at_the_same_moment_they_are_told_apart_by_name() -> None:
    one, other = Claims(1, "/a"), Claims(1, "/b")
    one.add(other.own(True).encode(), 0.0)
    other.add(one.own(True).encode(), 0.0)
    assert (one.reason(True, 0.0), bool(other.reason(True, 0.0))) == ("", True)


def test_one_that_died_counts_no_longer() -> None:
    first, second = pair()
    second.add(first.own(True).encode(), 0.0)
    assert second.reason(False, LASTS)
    assert second.reason(False, LASTS + 0.01) == ""


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"born": 1.5, "who": "/a", "drives": true}', "x" * 2000, "[" * 900])
def test_what_is_no_claim_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        decode(text)
    assert decode(Claim(3, "/a", True).encode()) == Claim(3, "/a", True)
