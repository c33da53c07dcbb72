"""Stamps as they should be: increasing, and the same clock for all topics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap.recordings.recording import LONGEST_PAUSE

Floats = npt.NDArray[np.float64]
Nanoseconds = npt.NDArray[np.int64]

USUAL_PERIOD = 25_000_000
"""[ns] between scans, for a recording of one scan."""


class Timeline(NamedTuple):
    """times (N,) [ns], increasing; by: "header", "log", or "repaired"; order: of the scans."""

    times: Nanoseconds
    by: str
    remarks: list[str]


def timeline(stamped: Nanoseconds, logged: Nanoseconds) -> Timeline:
    """The scans' times: their own stamps where those advance, else when they were logged, else put right."""
    wrong = int(np.count_nonzero(np.diff(stamped) <= 0))
    if not wrong:
        return Timeline(stamped, "header", _gaps(stamped))
    standing = int(np.count_nonzero(np.diff(stamped) == 0))
    said = f"{wrong} of {len(stamped)} stamps do not advance ({standing} stand still, {wrong - standing} jump back)"
    if np.all(np.diff(logged) > 0):
        return Timeline(logged, "log", [f"{said}: the times of logging are used", *_gaps(logged)])
    steps = np.diff(stamped)
    usual = int(np.median(steps[steps > 0])) if np.any(steps > 0) else USUAL_PERIOD
    times = stamped[0] + np.concatenate([[0], np.cumsum(np.where(steps > 0, steps, usual))])
    remark = f"{said}, nor do the times of logging: the usual {usual / 1e6:.1f} ms are taken there"
    return Timeline(times.astype(np.int64), "repaired", [remark, *_gaps(times)])


def _gaps(times: Nanoseconds) -> list[str]:
    pauses = np.diff(times) / 1e9
    long = pauses[pauses > LONGEST_PAUSE]
    if not len(long):
        return []
    return [f"{len(long)} gaps of more than {LONGEST_PAUSE:g} s, the longest {long.max():.1f} s: each is a new start"]


def periods(times: Nanoseconds, known: float | None = None, first: float | None = None) -> Floats:
    """(N,) [s] since the scan before. known: the exact period of a clock; first: of the first scan, else the usual."""
    steps = np.diff(times) / 1e9
    usual = known if known is not None else float(np.median(steps)) if len(steps) else USUAL_PERIOD / 1e9
    found = np.concatenate([[usual if first is None else first], steps])
    if known is not None:  # stamps hold whole nanoseconds, and scans may have been skipped
        exact = np.round(found / known) * known
        found = np.where(np.abs(found - exact) < 1.5e-9, exact, found)
    return np.asarray(found, dtype=np.float64)
