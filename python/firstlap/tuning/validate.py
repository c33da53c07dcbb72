"""Validation of a tuned setup: unseen seeds, the opposite direction, other tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from firstlap.config.parameters import Values
from firstlap.tracks.track import Track
from firstlap.tuning.candidate import Problem, Verdict
from firstlap.tuning.pool import Pool
from firstlap.tuning.selection import Progress, race_conditions
from firstlap.tuning.variation import drawn


@dataclass(frozen=True)
class Place:
    """Results of the tuned setup and of the one it is compared with, on one track and direction.

    own: whether this is the tuned track and direction.
    """

    name: str
    tuned: Verdict
    compared: Verdict
    own: bool = False

    @property
    def worse(self) -> bool:
        """On its own track: any failure. Elsewhere: more failures than the other setup."""
        return self.tuned.failed > (0 if self.own else self.compared.failed)


@dataclass(frozen=True)
class Validation:
    """All results and the conclusion."""

    compared: str
    places: list[Place]

    @property
    def over_tuned(self) -> bool:
        """Whether the setup is over-tuned to its track."""
        return any(place.worse for place in self.places)

    @property
    def verdict(self) -> str:
        """The conclusion in one sentence."""
        worse = [place.name for place in self.places if place.worse]
        if not worse:
            return f"over-tuned to this track: no (no failures where {self.compared} finishes)"
        return f"over-tuned to this track: yes (too many failures: {', '.join(worse)})"

    def to_dict(self) -> dict[str, Any]:
        """As in the JSON of `tune`."""
        return {
            "over_tuned": self.over_tuned,
            "verdict": self.verdict,
            "places": [
                {"name": place.name, "worse": place.worse, "tuned": _row(place.tuned), "compared": _row(place.compared)}
                for place in self.places
            ],
        }


def _row(verdict: Verdict) -> dict[str, Any]:
    found = asdict(verdict)
    return {
        "races": verdict.raced,
        "failed": verdict.failed,
        "lap": verdict.lap,
        "clearance": verdict.clearance,
        "outcomes": {outcome: found["outcomes"].count(outcome) for outcome in sorted(set(found["outcomes"]))},
    }


def validate(
    problem: Problem,
    tuned: Values,
    compared: tuple[str, Values],
    others: Mapping[str, Track],
    pool: Pool,
    judge: Mapping[str, float],
    seed: int,
    progress: Progress,
) -> Validation:
    """Races the tuned setup and the one it is compared with on all tracks. Raises PoolGoneError.

    problem: of the tuning. others: other tracks, by name.
    """
    fresh = replace(problem, laps=int(judge["check_laps"]), patient=True, slowest=0.0)
    unseen = drawn(int(judge["unseen_seeds"]), seed, "validation")
    few = unseen[: int(judge["other_seeds"])]
    places = [
        ("unseen seeds", problem.track, unseen, True),
        ("opposite direction", problem.track.reversed(), few, False),
        *((name, track, few, False) for name, track in others.items()),
    ]
    found = []
    for name, track, conditions, own in places[: None if few else 1]:
        here = replace(fresh, track=track)
        verdicts = [race_conditions(here, given, conditions, pool, progress) for given in (tuned, compared[1])]
        found.append(Place(name, verdicts[0], verdicts[1], own))
    return Validation(compared[0], found)
