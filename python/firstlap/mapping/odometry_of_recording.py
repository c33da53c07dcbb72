"""Checks a recording's odometry against its scans and commands."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from firstlap.config.car_file import Car
from firstlap.estimation.odometry_check import Contradiction, Odometry, Pair, Steps, judge
from firstlap.mapping.scan_motion import ScanMotion, ScanStep, as_steps
from firstlap.recordings import Recording
from firstlap.recordings.laser import car_of

STRIDE = 5
"""Steps between two checks."""
FEWEST = 5
"""Number of checks with the same result required for a remark."""
SHARE = 0.1
"""Share of all checks of the same two sources required for a remark."""
LONGEST = 120.0
"""[s] Duration that is checked; of a longer recording, in pieces spread over it."""
PIECES = 8
MEASURED = "odometry"
"""Prefix of `Recording.sources` for measured speeds."""


def remarks_of(recording: Recording, car: Car) -> tuple[str, ...]:
    """One line per contradiction; none if the car's motion was not measured."""
    if not recording.sources.get("speed", "none").startswith(MEASURED):
        return ()
    odometry = odometry_of(recording)
    if odometry is None:
        return ()
    found: dict[Pair, list[tuple[float, Contradiction | None]]] = defaultdict(list)
    for begin, end in pieces(recording.duration):
        steps = steps_of(recording, car, begin, end)
        for last in range(STRIDE, len(steps) + 1, STRIDE):
            for pair, verdict in judge(odometry, steps.part(0, last)).items():
                found[pair].append((float(steps.ends[last - 1]), verdict))
    return tuple(text for verdicts in found.values() if (text := _most_frequent(verdicts)))


def pieces(duration: float) -> Iterator[tuple[float, float]]:
    """(begin, end) [s] of the pieces that are checked."""
    if duration <= LONGEST:
        yield 0.0, duration
        return
    length = LONGEST / PIECES
    for begin in np.linspace(0.0, duration - length, PIECES):
        yield float(begin), float(begin) + length


def _most_frequent(verdicts: list[tuple[float, Contradiction | None]]) -> str:
    """The most frequent contradiction between two sources, if it is frequent enough, as text."""
    kinds: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for time, verdict in verdicts:
        if verdict is not None:
            kinds[verdict.kind].append((time, verdict.text))
    if not kinds:
        return ""
    # A twist in a fixed frame looks like one fault after the other as the car turns.
    most = kinds["frame"] if len(kinds["frame"]) >= FEWEST else max(kinds.values(), key=len)
    time, text = most[len(most) // 2]
    often = len(most) >= max(FEWEST, SHARE * len(verdicts))
    return f"{text} (at {time:.1f} s, and in {len(most)} of {len(verdicts)} comparisons)" if often else ""


def odometry_of(recording: Recording) -> Odometry | None:
    """The recorded odometry at the scans; None if there is too little."""
    if len(recording) < 2:
        return None
    lateral = np.zeros(len(recording)) if recording.lateral_speed is None else recording.lateral_speed
    twist = np.column_stack([recording.speed, lateral, recording.yaw_rate])
    poses = recording.odometry
    if poses is None and "pose" not in recording.topics:  # of the odometry then, not of a localizer
        poses = recording.poses
    return Odometry(recording.stamps, twist, poses)


def steps_of(recording: Recording, car: Car, begin: float, end: float) -> Steps:
    """The steps of the scans between two times [s]."""
    first, last = np.searchsorted(recording.stamps, [begin, end])
    motion = ScanMotion(car_of(recording, car))
    found: list[ScanStep] = []
    for i in range(int(first), min(int(last) + 1, len(recording))):
        step = motion.add(recording.scan(i), float(recording.stamps[i]))
        if step is not None:
            found.append(step)
    commands = recording.commands
    return as_steps(found, recording.stamps, np.full(len(recording), np.nan) if commands is None else commands.speed)
