"""Runs a driver on a recording: what would it have commanded?

The replay is open-loop: the recorded car determines the scans.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import Handle, Preparation, driver_kind
from firstlap.config.setup_file import LOCAL, Setup
from firstlap.evaluation.replay.continuity import BIG_JUMP, Continuity
from firstlap.evaluation.replay.estimated import with_estimate
from firstlap.mapping.contradictions import contradictions
from firstlap.recordings.body import BodyMask, find_body
from firstlap.recordings.laser import car_of
from firstlap.recordings.recording import Recording
from firstlap.recordings.replay_log import Log, log_of
from firstlap.recordings.step_log import STATUSES, Columns, rows_of

Floats = npt.NDArray[np.float64]

SCANS_PER_CALL = 100
PLANNED = (STATUSES.index("ok"), STATUSES.index("blocked"))
NOTHING = np.zeros((0, 2))
REACHES = (1.0, 2.0, 3.0)


@dataclass(frozen=True)
class ReplayResult:
    """The results of one setup on the recording: columns with one entry per scan. SI units.

    speed, steering_angle: commanded. status: index into STATUSES. microseconds: of the step. ahead: [m] of path before
    the front axle. width: remembered track width. width_seen: median where both walls are visible, NaN elsewhere.
    left, right: whether that wall is visible in this scan. jump: [m], NaN if it is undefined.
    changed: whether the side changed (see firstlap.evaluation.replay.continuity). From `ahead` on empty for drivers
    other than local.
    """

    setup: Setup
    speed: Floats
    steering_angle: Floats
    status: npt.NDArray[np.uint8]
    microseconds: Floats
    ahead: Floats
    width: Floats
    width_seen: Floats
    left: npt.NDArray[np.bool_]
    right: npt.NDArray[np.bool_]
    jump: Floats
    changed: npt.NDArray[np.bool_]

    def to_dict(self) -> dict[str, Any]:
        """Summary. Lengths in meters, shares of all scans; None if nothing could be measured."""
        names = [STATUSES[i] for i in self.status]
        planned = np.isin(self.status, PLANNED)[: len(self.ahead)]
        jumps = self.jump[np.isfinite(self.jump)]
        return {
            "driver": self.setup.driver,
            "setup": self.setup.name,
            "set": {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()},
            "statuses": {name: names.count(name) for name in STATUSES if name in names},
            "sides": {
                "both": share(self.left & self.right),
                "one": share(self.left ^ self.right),
                "none": share(~self.left & ~self.right),
            },
            "width": spread(self.width_seen, 5, 50, 95),
            "available": {f"{reach:g}": share(planned & (self.ahead >= reach)) for reach in REACHES},
            "jump": {**spread(self.jump, 50, 95), "big": share(jumps > BIG_JUMP), "scans": len(jumps)},
            "changes_of_side": {"count": int(self.changed.sum()), "share": share(self.changed)},
            "step_us": spread(self.microseconds, 50, 99),
        }


@dataclass(frozen=True)
class Replay:
    """A recording and the results of one or two setups."""

    recording: Recording
    car: Car
    driven: ReplayResult
    against: ReplayResult | None = None
    body: BodyMask | None = None
    remarks: tuple[str, ...] = ()
    seconds: float = 0.0
    reading: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap replay --json`."""
        recording, driven = self.recording, self.driven
        found: dict[str, Any] = {
            "version": __version__,
            "recording": recording.source,
            "topics": recording.topics,
            "sources": recording.sources,
            "remarks": [*recording.remarks, *self.remarks],
            "scans": len(recording),
            "seconds": round(recording.duration, 3),
            "from": round(float(recording.stamps[0]), 3),
            "car": self.car.name,
            **driven.to_dict(),
            "recorded": self._recorded(),
            "scans_per_second": self.rate,
        }
        if self.against is not None:
            found["against"] = self.against.to_dict()
            found["difference"] = difference(driven, self.against.speed, self.against.steering_angle)
        return found

    @property
    def rate(self) -> float:
        """Scans per second, including reading."""
        setups = 1 if self.against is None else 2
        return round(setups * len(self.recording) / max(self.seconds + self.reading, 1e-9), 1)

    def _recorded(self) -> dict[str, Any] | None:
        commands = self.recording.commands
        if commands is None:
            return None
        return {"topic": commands.topic, **difference(self.driven, commands.speed, commands.steering_angle)}

    def plot(self, path: str | Path) -> None:
        """Writes a plot over time. Raises InputError."""
        from firstlap.evaluation.replay.plot import plot_replay

        plot_replay(self, path)


def replay(
    recording: Recording,
    setup: Setup,
    car: Car,
    *,
    against: Setup | None = None,
    mask_body: bool = True,
    estimated: bool = False,
    on_progress: Callable[[int], object] | None = None,
    record: str | Path | None = None,
) -> Replay:
    """Runs `setup`, and `against`, on the recording.

    mask_body: mask returns from the car itself that the default mask misses, unless the setup sets its mask.
    estimated: the driver is given the state estimate, with the car's `state_estimate`. on_progress: called with the
    number of scans done, of both setups. record: an .mcap file for a log of `setup`. Raises InputError.
    """
    begin = time.perf_counter()
    car = car_of(recording, car)
    if estimated:
        recording = with_estimate(recording, car)
    setup, body, remarks = prepared(recording, setup, mask_body)
    with log_of(recording, setup, car, record) if record is not None else nullcontext() as log:
        driven = _drive(recording, setup, car, on_progress, log)
    other = None
    if against is not None:
        against, _, _ = prepared(recording, against, mask_body)
        other = _drive(recording, against, car, on_progress and (lambda done: on_progress(len(recording) + done)), None)
    return Replay(
        recording=recording,
        car=car,
        driven=driven,
        against=other,
        body=body,
        remarks=(*remarks, *contradictions(recording, car)),
        seconds=time.perf_counter() - begin,
    )


def prepared(recording: Recording, setup: Setup, mask_body: bool) -> tuple[Setup, BodyMask | None, tuple[str, ...]]:
    """The setup with the recording's LiDAR mounting and the mask of the car's body, and remarks on the changes.

    Values set by the user, the setup's file or our own log are kept.
    """
    if recording.about is not None or setup.driver != LOCAL:
        return setup, None, ()
    given = any(("scan", name) in setup.given for name in ("mask_angle", "mask_range"))
    body = find_body(recording, setup) if mask_body and not given else None
    if body is None:
        return setup, None, ()
    setup = setup.with_given({("scan", "mask_angle"): body.mask_angle, ("scan", "mask_range"): body.mask_range})
    return setup, body, (f"{body.beams} beams hit the car itself: masked by {body.assignments}",)


def driver_for(setup: Setup, car: Car) -> Handle:
    """The driver of the setup. Raises InputError if it needs a map, which a recording does not have."""
    kind = driver_kind(setup.driver)
    if kind.needs_map:
        raise InputError(f"driver {kind.name}: needs a map of the track before it drives; a recording has none")
    return kind.make(setup.params(car.core), car, Preparation())


def batches(recording: Recording, driver: _core.Driver) -> Iterator[tuple[slice, dict[str, Any]]]:
    """Steps through the recording; yields the number of scans done and their columns."""
    for first in range(0, len(recording), SCANS_PER_CALL):
        part = slice(first, min(first + SCANS_PER_CALL, len(recording)))
        scans = recording.ranges[part]
        yield (
            part,
            _core.replay(
                driver,
                np.concatenate(scans),
                np.array([len(one) for one in scans], dtype=np.int64),
                np.ascontiguousarray(recording.headers[part]),
                np.ascontiguousarray(recording.states[part]),
                np.ascontiguousarray(recording.dts[part]),
            ),
        )


@dataclass
class _Collected:
    """Columns of the batches so far."""

    parts: dict[str, list[npt.NDArray[Any]]] = field(default_factory=dict)

    def add(self, **columns: npt.NDArray[Any]) -> None:
        for name, values in columns.items():
            self.parts.setdefault(name, []).append(values)

    def whole(self) -> dict[str, npt.NDArray[Any]]:
        return {name: np.concatenate(parts) for name, parts in self.parts.items()}


def _drive(
    recording: Recording,
    setup: Setup,
    car: Car,
    on_progress: Callable[[int], object] | None,
    log: Log | None,
) -> ReplayResult:
    driver, continuity, collected = driver_for(setup, car), Continuity(), _Collected()
    for part, columns in batches(recording, driver.core):
        collected.add(**{name: columns[name] for name in ("speed", "steering_angle", "status", "microseconds")})
        collected.add(**{name: columns[name] for name in ("ahead", "width", "width_seen")})
        collected.add(left=columns["left_seen"] > 0, right=columns["right_seen"] > 0)
        collected.add(**_continued(recording, part, columns, continuity))
        if log:
            log.put(part, columns)
        if on_progress:
            on_progress(part.stop)
    return ReplayResult(setup=setup, **collected.whole())


def _continued(
    recording: Recording, part: slice, columns: Columns, continuity: Continuity
) -> dict[str, npt.NDArray[Any]]:
    found = []
    planned = np.isin(columns["status"], PLANNED)
    rows = (rows_of(columns, name) for name in ("path", "left", "right"))
    for i, (path, left, right) in enumerate(zip(*rows, strict=True)):
        ahead = path[columns["nearest"][i] :, 1:3] if planned[i] else NOTHING
        left, right = left[: columns["left_seen"][i], :2], right[: columns["right_seen"][i], :2]
        scan = part.start + i
        found.append(continuity.add(ahead, left, right, recording.states[scan], float(recording.dts[scan])))
    return {"jump": np.array([jump for jump, _ in found]), "changed": np.array([flag for _, flag in found], dtype=bool)}


def difference(driven: ReplayResult, speed: Floats, steering_angle: Floats) -> dict[str, Any]:
    """Absolute difference of the commands, median and 95th percentile, over the scans that have both."""
    return {
        "scans": int((np.isfinite(speed) | np.isfinite(steering_angle)).sum()),
        "speed": spread(np.abs(driven.speed - speed), 50, 95),
        "steering_angle": spread(np.abs(driven.steering_angle - steering_angle), 50, 95),
    }


def spread(values: Floats, *percents: int) -> dict[str, float | None]:
    """{"p5": ..., "median": ...} of the finite values."""
    good = values[np.isfinite(values)]
    found = np.percentile(good, percents) if len(good) else [None] * len(percents)
    names = ["median" if percent == 50 else f"p{percent}" for percent in percents]
    return {name: None if value is None else round(float(value), 5) for name, value in zip(names, found, strict=True)}


def share(flags: npt.NDArray[np.bool_]) -> float | None:
    """Share of true values."""
    return round(float(np.mean(flags)), 5) if len(flags) else None
