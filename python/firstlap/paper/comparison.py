"""The comparison of Section V-B: the paper's setting, tuned and untuned drivers, on one track."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from firstlap.common.cache import cache_folder
from firstlap.common.text import short_name
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import list_setups, load_setup
from firstlap.evaluation.compare.compare import Comparison, default_entries, parse_entries
from firstlap.evaluation.compare.record import Store
from firstlap.paper.settings import LAPS
from firstlap.tracks.track import Track

EXTRAS = ("casadi", "gtsam", "piqp")
"""Packages of the extra `global`."""


def compared_drivers(track: Track) -> str:
    """As of --drivers: those of `compare`, and our setups that were tuned for this track; without global where its
    packages are not installed."""
    words = [word for word in default_entries() if has_global() or not driver_kind(word.partition(":")[0]).needs_map]
    tuned = [load_setup(name) for name in list_setups()]
    words += [f"{setup.driver}:{setup.name}" for setup in tuned if setup.tuned_for == short_name(track.name)]
    return ",".join(words)


def has_global() -> bool:
    """Whether the packages of the map-based driver are installed."""
    return all(find_spec(name) is not None for name in EXTRAS)


def make_comparison(track: Track, car: Car, drivers: str | None, seeds: int, workers: int | None) -> Comparison:
    """The comparison, not driven; without latency, so that the same seeds give the same laps. Raises InputError."""
    return Comparison(
        track,
        parse_entries(compared_drivers(track) if drivers is None else drivers, car),
        car,
        laps=LAPS,
        seeds=seeds,
        latency="none",
        store=Store(Path(cache_folder("compare"))),
        jobs=workers,
    )
