"""The paper's six settings, from base to optimum: its three figures with our lap times and its lap times."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from firstlap import _core
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.parameters import Field, Value
from firstlap.config.setup_file import BASE, Setup, load_setup
from firstlap.sim.race import RaceResult, race
from firstlap.tracks.track import Track
from firstlap.tuning.plots import draw_laps, draw_parameters, embedded
from firstlap.tuning.report import number, page, table
from firstlap.tuning.settings import Setting

FIRST, LAST = BASE, "race"
PRINTED: Mapping[int, Mapping[str, float]] = {
    2: {"k_ang": 0.3, "l_max": 0.6, "v_min": 2.3, "v_max": 6.5},
    4: {"k_soft": 10.0, "k_damp": 10.0},
}
"""Values that the paper gives for the settings between the first and the last; others are kept."""
PRINTED_LAPS: Mapping[int, float] = {0: 17.5, 2: 15.6, 4: 14.3, 5: 12.8}
"""The paper's lap times [s]."""
STEERING = ("k_ang", "k_dist", "k_soft", "k_damp", "k_rate", "l_max")
MOTION = ("v_min", "v_max", "a_y_max", "a_x_max", "a_x_min")
SILENT = ("trajectory.", "velocity_profile.a_", "velocity_profile.friction")
"""Prefixes of parameters without values in the paper."""
COUNT = 6
LAPS = 4


@dataclass(frozen=True)
class SettingResult:
    """One of the six settings and its races."""

    setup: Setup
    results: list[RaceResult]

    @property
    def failed(self) -> int:
        """Number of races not finished."""
        return sum(not result.finished for result in self.results)

    @property
    def lap(self) -> float | None:
        """Median flying lap of the finished races [s]."""
        laps = [lap.time for result in self.results if result.finished for lap in result.laps if not lap.standing]
        return statistics.median(laps) if laps else None


def paper_settings() -> list[Setup]:
    """The six settings. Settings 1 and 3, which the paper does not give, are the means of their neighbors.

    Parameters without values in the paper (acceleration limits, smoothing) are interpolated from `base` to `race`.
    """
    first, last = load_setup(FIRST), load_setup(LAST)
    second = first.with_values(PRINTED[2])
    fourth = second.with_values(PRINTED[4])
    steps = [first, _between(first, second), second, _between(second, fourth), fourth, last]
    return [_silent(step, first, last, place) for place, step in enumerate(steps)]


def _between(a: Setup, b: Setup) -> Setup:
    keys = a.given.keys() | b.given.keys()
    return a.with_values({f"{s}.{n}": _mix(a.fields.find(f"{s}.{n}", "paper"), a, b, 0.5) for s, n in sorted(keys)})


def _silent(setup: Setup, first: Setup, last: Setup, place: int) -> Setup:
    keys = [f"{section}.{name}" for section, name in sorted(first.given.keys() | last.given.keys())]
    fields = [setup.fields.find(key, "paper") for key in keys if key.startswith(SILENT)]
    values = {field.key: _mix(field, first, last, place / (COUNT - 1)) for field in fields}
    return Setup(f"setting {place}", setup.with_values(values).given, "the paper")


def _mix(field: Field, a: Setup, b: Setup, share: float) -> Value:
    value = (1.0 - share) * float(a.get(field.key)) + share * float(b.get(field.key))
    return float(f"{value:.6g}") if field.type == "float" else round(value)


def drive_paper(
    track: Track, car: Car, seeds: int, done: Callable[[], object], on_progress: Callable[[_core.Race], object]
) -> list[SettingResult]:
    """Races every setting with seeds 1 to `seeds`, without spread, on all cores."""
    setups = paper_settings()
    options = {"record_path": False}

    def drive(setup: Setup, seed: int) -> RaceResult:
        return race(track, setup, car, laps=LAPS, seed=seed, options=options, on_progress=on_progress)

    with ThreadPoolExecutor() as pool:
        futures = [[pool.submit(drive, setup, seed) for seed in range(1, seeds + 1)] for setup in setups]
        try:
            found = []
            for setup, some in zip(setups, futures, strict=True):
                results = []
                for future in some:
                    results.append(future.result())
                    done()
                found.append(SettingResult(setup, results))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return found


def paper_summary(spec: str, track: Track, car: Car, driven: Sequence[SettingResult]) -> dict[str, Any]:
    """As in `firstlap tune --paper --json`."""
    first = driven[0].lap
    return {
        "version": __version__,
        "track": spec,
        "track_length": round(track.length, 6),
        "car": car.name,
        "settings": [
            {
                "setting": place,
                "values": {f"{section}.{name}": value for (section, name), value in one.setup.given.items()},
                "lap": one.lap,
                "less": 1.0 - one.lap / first if one.lap and first else None,
                "races": len(one.results),
                "failed": one.failed,
                "paper_lap": PRINTED_LAPS.get(place),
                "paper_less": 1.0 - PRINTED_LAPS[place] / PRINTED_LAPS[0] if place in PRINTED_LAPS else None,
            }
            for place, one in enumerate(driven)
        ],
    }


def paper_report(found: dict[str, Any], driven: Sequence[SettingResult]) -> str:
    """The report with the three figures."""
    settings = [Setting(str(place), one.setup.given, one.lap, one.failed == 0) for place, one in enumerate(driven)]
    table_of = driven[0].setup.fields
    rows = [
        (
            row["setting"],
            number(row["lap"]),
            _percent(row["less"]),
            f"{row['failed']} of {row['races']}",
            number(row["paper_lap"], 1),
            _percent(row["paper_less"]),
        )
        for row in found["settings"]
    ]
    words = (
        f"{found['track']}, {found['track_length']:.1f} m, car {found['car']}, version {__version__}. The paper gives "
        "settings 0 and 5 completely, the changes of 2 and 4, and nothing of 1 and 3 (interpolated here). It has no "
        "acceleration limits and no smoothing: these are interpolated from base to race. Its laps are of its own track."
    )
    return page(
        f"The paper's six settings on {found['track']}",
        [
            f"<p>{words}</p>",
            table(["setting", "lap [s]", "less than 0", "failed", "paper's lap [s]", "less than 0"], rows),
            "<h2>Steering parameters by setting</h2>",
            embedded(draw_parameters([table_of.find(name, "paper") for name in STEERING], settings), "steering"),
            "<h2>Motion parameters by setting</h2>",
            embedded(draw_parameters([table_of.find(name, "paper") for name in MOTION], settings), "motion"),
            "<h2>Lap time by setting</h2>",
            embedded(draw_laps(settings, PRINTED_LAPS), "lap time"),
        ],
    )


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.0f} %"
