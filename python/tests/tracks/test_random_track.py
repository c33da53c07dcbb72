"""Random tracks: every seed gives a valid track."""

from __future__ import annotations

import numpy as np
import pytest

from firstlap.tracks import random_track as module
from firstlap.tracks.medial import curvature
from firstlap.tracks.random_track import LENGTH, WIDTH, random_track


@pytest.mark.parametrize("seed", range(12))
def test_a_seed_that_draws_nothing_drivable_still_gives_a_drivable_track(
    monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    monkeypatch.setattr(module, "_attempt", lambda *_arguments, **_options: None)
    track = random_track(seed)
    assert track.name == f"random:{seed}"
    assert LENGTH[0] <= track.length <= LENGTH[1]
    assert track.width_summary()[0] >= WIDTH[0]
    assert 1.0 / np.abs(curvature(track.centerline)).max() >= 1.0
    np.testing.assert_array_equal(track.centerline, random_track(seed).centerline)


def test_attempts_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    attempts = []
    monkeypatch.setattr(module, "_attempt", lambda *arguments, **_options: attempts.append(arguments))
    random_track(1)
    assert len(attempts) == module.ATTEMPTS
