"""The paper's six settings from base to optimum, and its seventh, which was faster but not robust.

The paper prints gains and speeds, but neither acceleration limits nor smoothing nor tolerances. Those are held at the
values of `base`, all but one: at a constant cornering limit the published gains shorten a lap by a fifth, not by more
than a quarter as in the paper, so its limit must have risen as well. `RAISED` rises in equal steps to the value of
`race`.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.parameters import Field, Value
from firstlap.config.setup_file import LOCAL, Setup, load_setup
from firstlap.evaluation.published import CHANGES, FIRST, LAST, NOT_ROBUST, PUBLISHED, SETTING_LAPS
from firstlap.sim.race import RaceResult, race
from firstlap.tracks.track import Track
from firstlap.tuning.variation import Conditions, changed_car, corners, race_options

STEERING = ("k_ang", "k_dist", "k_soft", "k_damp", "k_rate", "l_max")
"""Of the paper's Figure 8."""
MOTION = ("v_min", "v_max", "a_y_max")
"""Of the paper's Figure 9; the last is not printed there."""
RAISED = "velocity_profile.a_y_max"
"""The only parameter that changes although the paper does not print it."""
NOT_ROBUST_RAISED = 5.0
"""[m/s^2] `RAISED` in the seventh setting, of which the paper gives the lap alone: 3 % below that of the sixth."""
COUNT = 6
LAPS = 4
SILENT_SECTIONS = ("trajectory", "minimum_curvature", "velocity_profile", "stanley")
"""Sections that hold published parameters, or that shape the path and the speed."""
SHOWN = (
    RAISED,
    "velocity_profile.a_x_max",
    "velocity_profile.a_x_min",
    "velocity_profile.friction_ellipse",
    "trajectory.smoothing_iterations",
    "trajectory.smoothing_margin",
    "trajectory.join_distance",
    "stanley.k_ag",
)
"""Silent parameters with the largest effect on a lap; reports have all."""


@dataclass(frozen=True)
class PaperPlan:
    """What is driven. seeds: races per setting as it is, and as many with the spread (`{name: half width}`).

    workers: races at a time; None: one per core.
    """

    settings: Sequence[Setup]
    spread: Mapping[str, float]
    seeds: int
    workers: int | None = None

    @property
    def races(self) -> int:
        """Total number of races."""
        return 2 * self.seeds * len(self.settings)


@dataclass(frozen=True)
class SettingResult:
    """One setting and its races: `results` without spread, `varied` with grip, delays, mass and start at the limits."""

    setup: Setup
    results: list[RaceResult]
    varied: list[RaceResult]

    @property
    def failed(self) -> int:
        """Number of races without spread that did not finish."""
        return sum(not result.finished for result in self.results)

    @property
    def varied_finished(self) -> int:
        """Number of races with spread that finished."""
        return sum(result.finished for result in self.varied)

    @property
    def flying(self) -> list[float]:
        """Flying laps of the finished races without spread [s]."""
        return [lap.time for result in self.results if result.finished for lap in result.laps if not lap.standing]

    @property
    def lap(self) -> float | None:
        """Median of `flying` [s]."""
        return statistics.median(self.flying) if self.flying else None

    @property
    def distance(self) -> float | None:
        """Median length of a flying lap of the finished races without spread [m]."""
        found = [lap.distance for result in self.results if result.finished for lap in result.laps if not lap.standing]
        return statistics.median(found) if found else None


def paper_settings(
    start: Setup | None = None, *, published_only: bool = False, changes: Sequence[str] = ()
) -> list[Setup]:
    """The settings in the paper's order; settings 1 and 3, which it does not print, are the means of their neighbors.

    start: has the values of all parameters that the paper does not print; default: `base`. published_only: change
    nothing but published parameters; then there is no seventh setting. changes: as of --set, in every setting. Raises
    InputError.
    """
    silent = load_setup(FIRST) if start is None else start
    if silent.driver != LOCAL:
        raise InputError(f"setup {silent.name} is for driver {silent.driver}; the paper's settings are for {LOCAL}")
    values = _published_values(silent)
    if not published_only:
        values = _with_limit(silent, values)
    settings = [silent.with_values(each).with_assignments(list(changes)) for each in values]
    return [Setup(f"setting {place}", each.given, "the paper") for place, each in enumerate(settings)]


def _published_values(silent: Setup) -> list[dict[str, Value]]:
    first, last = ({name: load_setup(setup).get(name) for name in PUBLISHED} for setup in (FIRST, LAST))
    second = {**first, **CHANGES[2]}
    fourth = {**second, **CHANGES[4]}
    return [first, _halfway(silent, first, second), second, _halfway(silent, second, fourth), fourth, last]


def _with_limit(silent: Setup, values: list[dict[str, Value]]) -> list[dict[str, Value]]:
    """The settings with `RAISED` in equal steps, and the seventh."""
    field = silent.fields.find(RAISED, "paper")
    low, high = silent.get(RAISED), load_setup(LAST).get(RAISED)
    raised = [interpolate(field, low, high, place / (COUNT - 1)) for place in range(COUNT)]
    steps = [{**each, RAISED: limit} for each, limit in zip(values, raised, strict=True)]
    return [*steps, {**values[-1], RAISED: NOT_ROBUST_RAISED}]


def _halfway(silent: Setup, a: Mapping[str, Value], b: Mapping[str, Value]) -> dict[str, Value]:
    return {name: interpolate(silent.fields.find(name, "paper"), a[name], b[name], 0.5) for name in a}


def interpolate(field: Field, a: Value, b: Value, share: float) -> Value:
    """The value between `a` and `b`, rounded to six digits.

    Raises ValueError for a switch, a choice or a count, and where one end, zero, turns something off: between two such
    values there is no third.
    """
    if field.type != "float" or (a != b and 0.0 in (a, b)):
        raise ValueError(f"{field.key} cannot be interpolated from {a} to {b}")
    return float(f"{(1.0 - share) * float(a) + share * float(b):.6g}")


def silent_fields(setup: Setup) -> list[Field]:
    """The parameters of path, speed and steering that the paper does not print."""
    return [row for row in setup.fields.fields if row.section in SILENT_SECTIONS and row.name not in PUBLISHED]


def drive_paper(
    track: Track, car: Car, plan: PaperPlan, done: Callable[[], object], on_progress: Callable[[_core.Race], object]
) -> list[SettingResult]:
    """Races every setting: seeds 1 to `plan.seeds` as they are, and as many with the spread."""
    conditions = corners(plan.seeds, 1)

    def drive(setup: Setup, seed: int) -> RaceResult:
        return race(track, setup, car, laps=LAPS, seed=seed, on_progress=on_progress)

    def vary(setup: Setup, under: Conditions) -> RaceResult:
        options = race_options(plan.spread, under)
        varied = changed_car(car, plan.spread, under)
        return race(track, setup, varied, laps=LAPS, seed=under.seed, options=options, on_progress=on_progress)

    with ThreadPoolExecutor(plan.workers) as pool:
        futures = [
            [pool.submit(drive, setup, seed) for seed in range(1, plan.seeds + 1)]
            + [pool.submit(vary, setup, under) for under in conditions]
            for setup in plan.settings
        ]
        try:
            found = []
            for setup, some in zip(plan.settings, futures, strict=True):
                results = []
                for future in some:
                    results.append(future.result())
                    done()
                found.append(SettingResult(setup, results[: plan.seeds], results[plan.seeds :]))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return found


def paper_summary(spec: str, track: Track, car: Car, driven: Sequence[SettingResult]) -> dict[str, Any]:
    """As in `firstlap tune --paper --json`."""
    return {
        "version": __version__,
        "track": spec,
        "track_length": round(track.length, 6),
        "car": car.name,
        "silent": {row.key: [one.setup.get(row.key) for one in driven] for row in silent_fields(driven[0].setup)},
        "settings": [_setting(place, one, driven[0].lap) for place, one in enumerate(driven)],
    }


def _setting(place: int, one: SettingResult, first: float | None) -> dict[str, Any]:
    published = SETTING_LAPS.get(place)
    return {
        "setting": place,
        "robust": place != NOT_ROBUST,
        "values": {f"{section}.{name}": value for (section, name), value in one.setup.given.items()},
        "lap": one.lap,
        "distance": one.distance,
        "less": 1.0 - one.lap / first if one.lap and first else None,
        "races": len(one.results),
        "failed": one.failed,
        "varied_races": len(one.varied),
        "varied_finished": one.varied_finished,
        "paper_lap": published,
        "paper_less": 1.0 - published / SETTING_LAPS[0] if published else None,
    }


def silent_sentences(found: Mapping[str, Any]) -> list[str]:
    """The silent parameters with the largest effect, each as "name value" or "name first to last"."""
    return [f"{key.rpartition('.')[2]} {values_text(found['silent'][key])}" for key in SHOWN]


def values_text(values: Sequence[Value]) -> str:
    """Values over the settings: one if all are the same, otherwise all."""
    words = [str(value).lower() if isinstance(value, bool) else f"{value:g}" for value in values]
    return words[0] if len(set(words)) == 1 else ", ".join(words)
