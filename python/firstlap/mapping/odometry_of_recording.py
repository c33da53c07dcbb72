"""What contradicts what in a recording: its odometry, its scans, its commands."""

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
"""Steps between two judgments."""
FEWEST = 5
"""Judgments of one kind that make a remark."""
SHARE = 0.1
"""And the share of all judgments of the same two witnesses that they must be."""
LONGEST = 120.0
"""[s] that are looked at; of a longer recording, so much in pieces spread over it."""
PIECES = 8
MEASURED = "odometry"
"""How `Recording.sources` begins where the speed was measured."""


def remarks_of(recording: Recording, car: Car) -> tuple[str, ...]:
    """One line for each contradiction; none where all agree, or where nothing was measured of the car's motion."""
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
    return tuple(text for verdicts in found.values() if (text := _told(verdicts)))


def pieces(duration: float) -> Iterator[tuple[float, float]]:
    """(begin, end) [s] of what is looked at."""
    if duration <= LONGEST:
        yield 0.0, duration
        return
    length = LONGEST / PIECES
    for begin in np.linspace(0.0, duration - length, PIECES):
        yield float(begin), float(begin) + length


def _told(verdicts: list[tuple[float, Contradiction | None]]) -> str:
    """What two witnesses contradict each other in most often, if that is often enough, in the words of one judgment."""
    kinds: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for time, verdict in verdicts:
        if verdict is not None:
            kinds[verdict.kind].append((time, verdict.text))
    if not kinds:
        return ""
    # A twist in a fixed frame looks like any other fault by turns.
    most = kinds["frame"] if len(kinds["frame"]) >= FEWEST else max(kinds.values(), key=len)
    time, text = most[len(most) // 2]
    often = len(most) >= max(FEWEST, SHARE * len(verdicts))
    return f"{text} (at {time:.1f} s, and so in {len(most)} of {len(verdicts)} comparisons)" if often else ""


def odometry_of(recording: Recording) -> Odometry | None:
    """The recorded odometry at the scans; None where there is too little of it."""
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
