"""Checks odometry for consistency with itself, with scan motion and with the commands. No ROS, no clock.

Each source reports the car's motion in a sequence of short steps: the odometry's twist, its poses, the scans, the
commands. Two sources are compared over the newest steps with enough motion: their ratio is 1, or it identifies the
fault. A delay is not a contradiction: the best-fitting delay is used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LAGS = (0.0, -0.1, -0.2, 0.1, 0.2, 0.3)
"""[s] Maximum delay of odometry relative to the reference."""
MOST_STEPS = 50
"""Maximum number of past steps used."""
FEWEST_STEPS = 8
ENOUGH_WAY = 0.6
"""[m] Motion required to compare speeds."""
ENOUGH_TURN = 0.8
"""[rad] Rotation required to compare yaw rates."""
SLOW, SLOW_TURN = 0.2, 0.5
"""[m/s], [rad/s] Mean below which offsets dominate factors."""
GROSS = 1.8
"""Factor between two sources, in either direction, from which on the car must not drive."""
NOTABLE = 1.3
"""Factor that is reported as a remark."""
NEAR = 0.25
"""Relative difference within which a ratio is identified with a known one."""
NOTHING = 0.1
"""A ratio below this means that the source reports no motion."""
STANDS, STANDS_TURN = 0.1, 0.1
"""[m/s], [rad/s] Upper limits for a stationary car."""
ROLLS = 4.0
"""Multiple of those limits that no sensor offset explains."""
STILL, STILL_TURN = 0.05, 0.05
"""[m/s], [rad/s] Upper limits of the scan motion of a stationary car."""
WILD_TURN, WILD = 2.0, 5.0
"""[rad/s] Yaw rate, and its multiple of the reference, that are reported without waiting for a turn."""
STANDING_STEPS = STEADY_STEPS = 10
"""Number of newest steps in which the car must be stationary, or the commands steady."""
SIDEWAYS = 0.4
"""Lateral share of a twist above which its frame is checked."""
FITS, FITS_NOT = 0.2, 0.35
"""Relative residual of two motions: below the first they agree, above the second they differ."""
NOTABLE_ANGLE, GROSS_ANGLE, BACKWARD = 25.0, 45.0, 160.0
"""[degrees] Angle between twist and scan motion: remark, must not drive, opposite direction."""
STEADY = 0.2
"""Relative change of commanded and measured speed up to which they count as steady."""
COMMANDED = 0.3
"""[m/s] Commanded speed required to compare it with the measured speed."""
UNITS = {
    "speed": (3.6, "km/h instead of m/s"),
    "yaw rate": (math.degrees(1.0), "degrees per second instead of radians"),
}
"""The most common wrong unit of each quantity: factor and name."""

SPEED, YAW_RATE = "speed", "yaw rate"
TWIST, POSES, SCANS, COMMANDS = "the odometry's twist", "its poses", "the scans", "the commands"
STANDING = "standing"


@dataclass(frozen=True)
class Odometry:
    """Recorded odometry.

    times: (M,) [s], increasing. twist: (M, 3) forward, left [m/s], yaw rate [rad/s]. poses: (M, 3) x, y [m], yaw [rad]
    in a fixed frame; None if there are none. turning: the source of the yaw rate.
    """

    times: Floats
    twist: Floats
    poses: Floats | None = None
    turning: str = TWIST


@dataclass(frozen=True)
class Steps:
    """Steps of the car by scan matching, in order of time.

    begins, ends: (K,) [s]. motion: (K, 3) forward, left [m], rotation [rad] of base_link in its frame at the beginning;
    NaN if the scans do not determine it. commands: (K,) [m/s] commanded at the step's end; NaN if there was none.
    """

    begins: Floats
    ends: Floats
    motion: Floats
    commands: Floats

    def __len__(self) -> int:
        return len(self.begins)

    def part(self, begin: int, end: int) -> Steps:
        """The steps from index `begin` to before `end`."""
        part = slice(begin, end)
        return Steps(self.begins[part], self.ends[part], self.motion[part], self.commands[part])


@dataclass(frozen=True)
class Contradiction:
    """kind: sign, zero, frame, unit, scale, standing or direction. gross: the car must not drive on such odometry."""

    kind: str
    text: str
    gross: bool


class Pair(NamedTuple):
    """A comparison: the quantity and its reference."""

    quantity: str
    reference: str


Verdicts = dict[Pair, Contradiction | None]
"""The comparisons made and the contradictions found; a pair without enough motion is missing."""


class Comparison(NamedTuple):
    """ratio: measured over reference. measured, reference: mean magnitudes [m/s] or [rad/s]."""

    ratio: float
    measured: float
    reference: float


class _Moved(NamedTuple):
    """(K, 3) forward, left [m], rotation [rad] of each step by the twist, by the poses, and by the twist interpreted in
    the frame of the poses; NaN without poses."""

    twist: Floats
    poses: Floats
    turned: Floats


def judge(odometry: Odometry, steps: Steps) -> Verdicts:
    """Compares the newest steps for which odometry is available, allowing for its delay."""
    if len(odometry.times) < 2:
        return {}
    first = int(np.searchsorted(steps.begins, odometry.times[0] - min(LAGS)))
    last = int(np.searchsorted(steps.ends, odometry.times[-1] - max(LAGS), side="right"))
    steps = steps.part(max(first, last - MOST_STEPS), last)
    if not len(steps):
        return {}
    seconds = steps.ends - steps.begins
    moved = [_moved(odometry, steps, lag) for lag in LAGS]
    verdicts: Verdicts = {}
    for quantity, column in ((SPEED, 0), (YAW_RATE, 2)):
        by_scans = [(one.twist[:, column], steps.motion[:, column]) for one in moved]
        by_poses = [(one.twist[:, column], one.poses[:, column]) for one in moved]
        for reference, pairs in ((SCANS, by_scans), (POSES, by_poses)):
            found = compare(pairs, seconds, quantity)
            if found is not None:
                verdicts[Pair(quantity, reference)] = _named(quantity, _measured(quantity, odometry), reference, found)
    _check_wild_turns(verdicts, moved, steps, odometry.turning)
    _check_direction(verdicts, moved, steps)
    _check_frame(verdicts, moved)
    _check_standing(verdicts, moved, steps, odometry.turning)
    _check_commands(verdicts, moved[0].twist[:, 0], steps)
    return _weighed(verdicts)


def gross(verdicts: Verdicts) -> str:
    """Why the car must not drive; empty if no gross contradiction was found."""
    return next((found.text for found in verdicts.values() if found is not None and found.gross), "")


def _moved(odometry: Odometry, steps: Steps, lag: float) -> _Moved:
    times, begins, ends = odometry.times, steps.begins + lag, steps.ends + lag

    def at(values: Floats, when: Floats) -> Floats:
        columns = [np.interp(when, times, column, left=math.nan, right=math.nan) for column in values.T]
        return np.column_stack(columns)

    halves = 0.5 * (odometry.twist[1:] + odometry.twist[:-1]) * np.diff(times)[:, None]
    way = np.vstack([np.zeros((1, 3)), np.cumsum(halves, axis=0)])
    twist = at(way, ends) - at(way, begins)
    if odometry.poses is None:
        unknown = np.full_like(twist, math.nan)
        return _Moved(twist, unknown, unknown)
    before, after = at(odometry.poses, begins), at(odometry.poses, ends)
    middle = 0.5 * (before[:, 2] + after[:, 2])
    return _Moved(twist, _seen_from(middle, after - before), _seen_from(middle, twist))


def _seen_from(yaw: Floats, moved: Floats) -> Floats:
    """(K, 3) motions in a fixed frame, rotated into the frame of a car with that yaw."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = moved[:, 0], moved[:, 1]
    return np.column_stack([c * x + s * y, -s * x + c * y, moved[:, 2]])


def compare(pairs: list[tuple[Floats, Floats]], seconds: Floats, quantity: str) -> Comparison | None:
    """Compares measured with reference steps, one pair per delay; the best-fitting delay is used.

    seconds: (K,) durations of the steps. None if the reference has too little motion.
    """
    best: tuple[float, Comparison] | None = None
    for measured, reference in pairs:
        found = _regressed(measured, reference, seconds, quantity)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    return None if best is None else best[1]


def _regressed(measured: Floats, reference: Floats, seconds: Floats, quantity: str) -> tuple[float, Comparison] | None:
    """Residual of the hypothesis that both are equal, and the ratio, over the newest steps with enough motion."""
    enough, slow = (ENOUGH_WAY, SLOW) if quantity == SPEED else (ENOUGH_TURN, SLOW_TURN)
    good = np.isfinite(measured) & np.isfinite(reference)
    a, b, dt = measured[good], reference[good], seconds[good]
    if len(b) < FEWEST_STEPS:
        return None
    way = np.cumsum(np.abs(b[::-1]))
    reached = int(np.searchsorted(way, enough))
    if reached >= len(b):
        return None
    count = max(reached + 1, FEWEST_STEPS)
    a, b, dt = a[-count:], b[-count:], dt[-count:]
    if float(np.abs(b).sum()) < slow * float(dt.sum()):
        return None
    kept = np.ones(len(b), dtype=bool)
    kept[np.argmax(np.abs(b) / dt)] = False  # a pose that jumps
    kept[np.argmax(np.abs(a - b) / dt)] = False
    a, b, dt = a[kept], b[kept], dt[kept]
    total, squares = float(dt.sum()), float(b @ b)
    if squares <= 0.0 or float(np.abs(b).sum()) < slow * total:
        return None  # without the jump nothing moved
    residual = float(np.sum((a - b) ** 2)) / squares
    return residual, Comparison(float(a @ b) / squares, float(np.abs(a).sum()) / total, float(np.abs(b).sum()) / total)


def _measured(quantity: str, odometry: Odometry) -> str:
    return TWIST if quantity == SPEED else odometry.turning


def _named(quantity: str, measured: str, reference: str, found: Comparison) -> Contradiction | None:
    """The fault that a ratio indicates; None if there is none."""
    ratio = found.ratio
    if 1.0 / NOTABLE <= ratio <= NOTABLE:
        return None
    kind, why = _explained(quantity, ratio, found)
    unit = "m/s" if quantity == SPEED else "rad/s"
    value = math.copysign(found.measured, ratio)
    text = f"{quantity}: {measured} says {value:.2f} {unit} where {reference} say {found.reference:.2f} {unit}: {why}"
    return Contradiction(kind, text, not 1.0 / GROSS <= ratio <= GROSS)


def _explained(quantity: str, ratio: float, found: Comparison) -> tuple[str, str]:
    if found.measured < NOTHING * found.reference:
        return "zero", "it stands at 0"
    if abs(ratio + 1.0) <= NEAR:
        return "sign", "the wrong sign"
    factor, name = UNITS[quantity]
    if abs(abs(ratio) / factor - 1.0) <= NEAR:
        return "unit", f"{name}{', with the wrong sign' if ratio < 0.0 else ''}?"
    if ratio < 0.0:
        return "sign", f"the wrong sign, and a factor of {-ratio:.2f}"
    return "scale", f"a factor of {ratio:.2f}"


def _check_frame(verdicts: Verdicts, moved: list[_Moved]) -> None:
    """Reports a twist that agrees with its poses only if interpreted in their frame."""
    found = [(_unlike(one.twist, one.poses), _unlike(one.turned, one.poses)) for one in moved]
    apart = [(there, turned) for there, turned in found if there is not None and turned is not None]
    if not apart or min(there for there, _ in apart) < FITS_NOT or min(turned for _, turned in apart) > FITS:
        return
    text = f"{TWIST} agrees with {POSES} only if it is in their frame: it must be in the frame of the car"
    verdicts[Pair(SPEED, POSES)] = Contradiction("frame", text, True)
    verdicts.pop(Pair(SPEED, SCANS), None)  # the same, less clearly said


def _unlike(a: Floats, b: Floats) -> float | None:
    """Relative difference of two planar motions; None if there is too little motion."""
    good = np.isfinite(a[:, :2]).all(axis=1) & np.isfinite(b[:, :2]).all(axis=1)
    a, b = a[good][:, :2], b[good][:, :2]
    reached = int(np.searchsorted(np.cumsum(np.hypot(*b[::-1].T)), ENOUGH_WAY))
    if len(b) < FEWEST_STEPS or reached >= len(b):
        return None
    count = max(reached + 1, FEWEST_STEPS)
    apart, way = np.hypot(*(a - b)[-count:].T), np.hypot(*b[-count:].T)
    jump = int(np.argmax(way))
    rest = float(way.sum() - way[jump])
    return float(apart.sum() - apart[jump]) / rest if rest > 0.0 else None


def _check_direction(verdicts: Verdicts, moved: list[_Moved], steps: Steps) -> None:
    """Reports scan motion with the length but not the direction of the twist: the LiDAR or the twist is rotated."""
    pair = Pair(SPEED, SCANS)
    twist, scans = moved[0].twist[:, :2], steps.motion[:, :2]
    good = np.isfinite(twist).all(axis=1) & np.isfinite(scans).all(axis=1)
    twist, scans = twist[good], scans[good]
    way, seen = float(np.hypot(*twist.T).sum()), float(np.hypot(*scans.T).sum())
    if len(twist) < FEWEST_STEPS or min(way, seen) < ENOUGH_WAY or not 1.0 / NOTABLE < way / seen < NOTABLE:
        return
    found = verdicts.get(pair)
    sense = np.sign(twist[:, 0])
    angle = math.degrees(math.atan2(float(sense @ scans[:, 1]), float(sense @ scans[:, 0])))
    if float(np.abs(twist[:, 1]).sum()) > SIDEWAYS * way:
        if found is not None:
            text = f"{TWIST} is lateral where {SCANS} move forward: it must be in the frame of the car"
            verdicts[pair] = Contradiction("frame", text, found.gross)
    elif abs(angle) > BACKWARD and found is not None:
        text = f"{found.text}, or a LiDAR that points backward"
        verdicts[pair] = Contradiction(found.kind, text, found.gross)
    elif NOTABLE_ANGLE < abs(angle) <= BACKWARD:
        side = "left" if angle > 0.0 else "right"
        text = f"{TWIST} is forward where {SCANS} move {abs(angle):.0f}° to the {side}: is the LiDAR yaw wrong?"
        verdicts[pair] = Contradiction("direction", text, abs(angle) > GROSS_ANGLE)


def _check_wild_turns(verdicts: Verdicts, moved: list[_Moved], steps: Steps, turning: str) -> None:
    """Reports yaw rates far above the reference even if the car hardly turns; mostly degrees per second."""
    last = slice(-STANDING_STEPS, None)
    seconds, told = (steps.ends - steps.begins)[last], moved[0].twist[last, 2]
    for reference, turns in ((SCANS, steps.motion[last, 2]), (POSES, moved[0].poses[last, 2])):
        if len(told) < STANDING_STEPS or not (np.isfinite(told).all() and np.isfinite(turns).all()):
            continue
        said, true = (float(np.abs(one).sum() / seconds.sum()) for one in (told, turns))
        if said > WILD_TURN and said > WILD * true:
            text = f"{YAW_RATE}: {turning} says {said:.2f} rad/s where {reference} say {true:.2f} rad/s"
            verdicts[Pair(YAW_RATE, reference)] = Contradiction("unit", f"{text}: {UNITS[YAW_RATE][1]}?", True)


def _check_standing(verdicts: Verdicts, moved: list[_Moved], steps: Steps, turning: str) -> None:
    """Reports a twist that moves while the scans do not. On a stand, commanded wheels do."""
    last = slice(-STANDING_STEPS, None)
    seconds, scans = (steps.ends - steps.begins)[last], steps.motion[last]
    if len(scans) < STANDING_STEPS or not np.isfinite(scans).all():
        return
    total = float(seconds.sum())
    still = np.abs(scans.sum(axis=0)) / total
    if still[0] > STILL or still[1] > STILL or still[2] > STILL_TURN:
        return
    driven = bool(np.any(np.nan_to_num(steps.commands[last]) > STANDS))

    def mean(column: int) -> float | None:
        told = [one.twist[last, column] for one in moved]
        means = [float(one.sum()) / total for one in told if np.isfinite(one).all()]
        return min(means, key=abs) if means else None

    speed, rate = mean(0), mean(2)
    if speed is not None and rate is not None:
        verdicts[Pair(SPEED, STANDING)] = _standing(f"{SPEED}: {TWIST} says {speed:.2f} m/s", speed / STANDS, driven)
        verdicts[Pair(YAW_RATE, STANDING)] = _standing(
            f"{YAW_RATE}: {turning} says {rate:.2f} rad/s", rate / STANDS_TURN, driven
        )


def _standing(said: str, offset: float, driven: bool) -> Contradiction | None:
    """offset: as a multiple of the limit for a stationary car."""
    if abs(offset) <= 1.0:
        return None
    why = "do the wheels turn on a stand?" if driven else "does the car stand? calibrate the offset"
    return Contradiction("standing", f"{said} while {SCANS} do not move: {why}", abs(offset) > ROLLS and not driven)


def _check_commands(verdicts: Verdicts, twist: Floats, steps: Steps) -> None:
    """Compares commanded and measured speed while both are steady."""
    last = slice(-STEADY_STEPS, None)
    commands, measured = steps.commands[last], (twist / (steps.ends - steps.begins))[last]
    if len(commands) < STEADY_STEPS or not (np.isfinite(commands).all() and np.isfinite(measured).all()):
        return
    half = STEADY_STEPS // 2
    told, said = float(commands.mean()), float(measured.mean())
    change = abs(float(measured[half:].mean() - measured[:half].mean()))
    if told < COMMANDED or abs(said) < STANDS or float(np.ptp(commands)) > STEADY * told or change > STEADY * abs(said):
        return
    verdicts[Pair(SPEED, COMMANDS)] = _commanded(told, said)


def _commanded(told: float, said: float) -> Contradiction | None:
    ratio = said / told
    if 1.0 / NOTABLE <= ratio <= NOTABLE:
        return None
    _, why = _explained(SPEED, ratio, Comparison(ratio, abs(said), told))
    text = f"{SPEED}: {TWIST} says {said:.2f} m/s where {COMMANDS} say {told:.2f} m/s: {why}"
    return Contradiction("commands", text, ratio < 0.0 or ratio > GROSS)


def _weighed(verdicts: Verdicts) -> Verdicts:
    """Reduces a contradiction to a remark if twist and scans agree: the poses or the commands are wrong."""
    for pair, found in verdicts.items():
        by_scans = Pair(pair.quantity, SCANS)
        agrees = by_scans in verdicts and verdicts[by_scans] is None
        if found is not None and agrees and pair.reference in (POSES, COMMANDS):
            verdicts[pair] = Contradiction(found.kind, f"{found.text}; the scans agree with the twist", False)
    return verdicts
