"""Corrects stamps: increasing, and on the same clock for all topics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap.common.text import counted
from firstlap.perception import scan
from firstlap.perception.scan import sweep_time
from firstlap.recordings.recording import LONGEST_PAUSE

Floats = npt.NDArray[np.float64]
Nanoseconds = npt.NDArray[np.int64]

USUAL_PERIOD = round(scan.USUAL_PERIOD * 1e9)
"""[ns] Scan period assumed for a recording of one scan."""


CLOCKS_APART = 0.5
"""[s] Difference of stamps from which on they are from different clocks; smaller ones are transport delays."""


class Timeline(NamedTuple):
    """times (N,) [ns] of the scans' last beams, increasing; by: "header", "log", or "repaired".

    logged_ahead: median of `times` minus log times [ns].
    """

    times: Nanoseconds
    by: str
    remarks: list[str]
    logged_ahead: int = 0

    def of_logging(self, logged: Nanoseconds) -> Nanoseconds:
        """Converts log times to the scans' clock."""
        return logged - self.logged_ahead if abs(self.logged_ahead) > CLOCKS_APART * 1e9 else logged

    def apart(self, stamped: Nanoseconds, logged: Nanoseconds) -> float:
        """Offset [s] of another topic's stamps from the scans' clock; 0 if it is the same clock or unknown."""
        if len(np.unique(logged)) * 2 <= len(logged):
            return 0.0
        apart = (self.logged_ahead - float(np.median(logged - stamped))) / 1e9
        return apart if abs(apart) > CLOCKS_APART else 0.0


def usual_period(times: Nanoseconds) -> int:
    """Median difference [ns] of consecutive times (N,), of those that increase."""
    steps = np.diff(times)
    return int(np.median(steps[steps > 0])) if np.any(steps > 0) else USUAL_PERIOD


def sweep(time_increment: float, beams: int, period: float) -> int:
    """[ns] from a scan's first beam (the time of its stamp) to its last (the time the planner uses).

    time_increment, period: [s]. 0 where `sweep_time` is.
    """
    return round(sweep_time(float(np.float32(time_increment)), beams, period) * 1e9)  # as messages hold it


def sweeps(time_increments: Floats, beams: list[int], stamped: Nanoseconds) -> Nanoseconds:
    """(N,) [ns], one each; `sweep`."""
    period = usual_period(stamped) / 1e9
    each = [sweep(increment, count, period) for increment, count in zip(time_increments, beams, strict=True)]
    return np.array(each, dtype=np.int64)


def timeline(ended: Nanoseconds, logged: Nanoseconds) -> Timeline:
    """The scans' times: their stamps if these increase, else their log times, else repaired.

    ended: (N,) [ns] of the last beams by the scans' stamps. logged: (N,) log times [ns].
    """
    wrong = int(np.count_nonzero(np.diff(ended) <= 0))
    if not wrong:
        return Timeline(ended, "header", _gaps(ended), int(np.median(logged - ended)))
    standing = int(np.count_nonzero(np.diff(ended) == 0))
    said = f"{wrong} of {len(ended)} stamps do not increase ({standing} repeated, {wrong - standing} backward)"
    if np.all(np.diff(logged) > 0):
        return Timeline(logged, "log", [f"{said}: log times are used", *_gaps(logged)])
    steps, usual = np.diff(ended), usual_period(ended)
    times = (ended[0] + np.concatenate([[0], np.cumsum(np.where(steps > 0, steps, usual))])).astype(np.int64)
    remark = f"{said}, nor do the log times: the median of {usual / 1e6:.1f} ms is assumed there"
    return Timeline(times, "repaired", [remark, *_gaps(times)], int(np.median(logged - times)))


def _gaps(times: Nanoseconds) -> list[str]:
    pauses = np.diff(times) / 1e9
    long = pauses[pauses > LONGEST_PAUSE]
    if not len(long):
        return []
    gaps = counted(len(long), "gap")
    return [f"{gaps} of more than {LONGEST_PAUSE:g} s, the longest {long.max():.1f} s: the planner is reset after each"]


def periods(times: Nanoseconds, known: float | None = None, first: float | None = None) -> Floats:
    """(N,) [s] since the previous scan. known: the exact period; first: of the first scan; default: the median."""
    steps = np.diff(times) / 1e9
    usual = known if known is not None else float(np.median(steps)) if len(steps) else USUAL_PERIOD / 1e9
    found = np.concatenate([[usual if first is None else first], steps])
    if known is not None:  # stamps are whole nanoseconds, and scans may have been skipped
        exact = np.round(found / known) * known
        found = np.where(np.abs(found - exact) < 1.5e-9, exact, found)
    return np.asarray(found, dtype=np.float64)
