"""Whether odometry agrees with itself, with the motion of the scans and with the commands. No ROS, no clock.

Every witness says how far the car went in each of a row of short steps: the odometry's twist, its poses, the scans, the
commands. Two of them are compared over the newest steps that hold enough motion: the ratio of one to the other is 1, or
it names the fault. A delay of a witness is no contradiction: the delay that fits best counts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LAGS = (0.0, -0.1, -0.2, 0.1, 0.2, 0.3)
"""[s] by which odometry may be later than what it is compared with."""
MOST_STEPS = 50
"""Steps that are looked back over at most."""
FEWEST_STEPS = 8
ENOUGH_WAY = 0.6
"""[m] of motion that a comparison of speeds wants."""
ENOUGH_TURN = 0.8
"""[rad] of turning that a comparison of yaw rates wants."""
SLOW, SLOW_TURN = 0.2, 0.5
"""[m/s], [rad/s] on average below which offsets, not factors, are what one sees."""
GROSS = 1.8
"""Factor between two witnesses, either way, from which on the car must not drive."""
NOTABLE = 1.3
"""Factor that is worth a remark."""
NEAR = 0.25
"""A ratio this near to a known one, as a share of it, is taken for it."""
NOTHING = 0.1
"""A ratio below this is a witness that stands still."""
STANDS, STANDS_TURN = 0.1, 0.1
"""[m/s], [rad/s] of a car that stands."""
ROLLS = 4.0
"""Times as much, which no offset of a sensor explains."""
STILL, STILL_TURN = 0.05, 0.05
"""[m/s], [rad/s] of scans that stand."""
WILD_TURN, WILD = 2.0, 5.0
"""[rad/s] that a yaw rate says, and times what the reference says, which no turn needs to be waited for."""
STANDING_STEPS = STEADY_STEPS = 10
"""Newest steps over which a car must stand, or commands be steady."""
SIDEWAYS = 0.4
"""Share of the length of a twist across the car from which on its frame is in doubt."""
FITS, FITS_NOT = 0.2, 0.35
"""Residual of two motions as a share of their length: they are the same, or they are not."""
NOTABLE_ANGLE, GROSS_ANGLE, BACKWARD = 25.0, 45.0, 160.0
"""[degrees] between the twist and the scans: worth a remark, not to be driven with, the other way round."""
STEADY = 0.2
"""Share by which commanded and measured speed may change while they are compared."""
COMMANDED = 0.3
"""[m/s] that must be commanded for it to be compared with what is measured."""
UNITS = {
    "speed": (3.6, "km/h instead of m/s"),
    "yaw rate": (math.degrees(1.0), "degrees per second instead of radians"),
}
"""The unit that each quantity is most often wrong by: its factor and name."""

SPEED, YAW_RATE = "speed", "yaw rate"
TWIST, POSES, SCANS, COMMANDS = "the odometry's twist", "its poses", "the scans", "the commands"
STANDING = "standing"


@dataclass(frozen=True)
class Odometry:
    """What the odometry said.

    times: (M,) [s], increasing. twist: (M, 3) forward, left [m/s], yaw rate [rad/s]. poses: (M, 3) x, y [m], yaw [rad]
    in a frame that does not move with the car; None where there are none. turning: what the yaw rate is of.
    """

    times: Floats
    twist: Floats
    poses: Floats | None = None
    turning: str = TWIST


@dataclass(frozen=True)
class Steps:
    """Steps of the car in the order of time, by the scans.

    begins, ends: (K,) [s]. motion: (K, 3) forward, left [m], turn [rad] of base_link as seen at the step's begin; NaN
    where the scans do not tell. commands: (K,) [m/s] commanded at the step's end; NaN where none was.
    """

    begins: Floats
    ends: Floats
    motion: Floats
    commands: Floats

    def __len__(self) -> int:
        return len(self.begins)

    def part(self, begin: int, end: int) -> Steps:
        """Those from index `begin` to before `end`."""
        part = slice(begin, end)
        return Steps(self.begins[part], self.ends[part], self.motion[part], self.commands[part])


@dataclass(frozen=True)
class Contradiction:
    """kind: sign, zero, frame, unit, scale, standing or direction. gross: the car must not drive on such odometry."""

    kind: str
    text: str
    gross: bool


class Pair(NamedTuple):
    """What was compared: the quantity and the witness that it was held against."""

    quantity: str
    reference: str


Verdicts = dict[Pair, Contradiction | None]
"""What was judged, and what contradicts; a pair without enough motion is missing."""


class Comparison(NamedTuple):
    """ratio: of the measured to the reference. measured, reference: [m/s] or [rad/s], means of their sizes."""

    ratio: float
    measured: float
    reference: float


class _Moved(NamedTuple):
    """(K, 3) forward, left [m], turn [rad] of each step by the twist and by the poses, and as the twist would have it
    if it were in the frame of the poses; NaN without poses."""

    twist: Floats
    poses: Floats
    turned: Floats


def judge(odometry: Odometry, steps: Steps) -> Verdicts:
    """Everything that the newest steps tell whose odometry is there, late as it may be."""
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
    _look_at_wild_turns(verdicts, moved, steps, odometry.turning)
    _look_at_direction(verdicts, moved, steps)
    _look_at_frame(verdicts, moved)
    _look_at_standing(verdicts, moved, steps, odometry.turning)
    _look_at_commands(verdicts, moved[0].twist[:, 0], steps)
    return _weighed(verdicts)


def gross(verdicts: Verdicts) -> str:
    """Why the car must not drive; empty where nothing gross was found."""
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
    """(K, 3) motions in a fixed frame as a car of that yaw sees them."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = moved[:, 0], moved[:, 1]
    return np.column_stack([c * x + s * y, -s * x + c * y, moved[:, 2]])


def compare(pairs: list[tuple[Floats, Floats]], seconds: Floats, quantity: str) -> Comparison | None:
    """Holds measured steps against reference steps, one pair for each delay; the delay that fits best counts.

    seconds: (K,) that the steps last. None where there is too little motion of the reference.
    """
    best: tuple[float, Comparison] | None = None
    for measured, reference in pairs:
        found = _regressed(measured, reference, seconds, quantity)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    return None if best is None else best[1]


def _regressed(measured: Floats, reference: Floats, seconds: Floats, quantity: str) -> tuple[float, Comparison] | None:
    """Residual of "they are the same", and the ratio, over the newest steps with enough motion."""
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
    """The fault that a ratio stands for; None where there is none."""
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


def _look_at_frame(verdicts: Verdicts, moved: list[_Moved]) -> None:
    """A twist that fits its poses only where it is taken to be in their frame is in that frame."""
    found = [(_unlike(one.twist, one.poses), _unlike(one.turned, one.poses)) for one in moved]
    apart = [(there, turned) for there, turned in found if there is not None and turned is not None]
    if not apart or min(there for there, _ in apart) < FITS_NOT or min(turned for _, turned in apart) > FITS:
        return
    text = f"{TWIST} does not fit {POSES} but where it is in their frame: it must be in the frame of the car"
    verdicts[Pair(SPEED, POSES)] = Contradiction("frame", text, True)
    verdicts.pop(Pair(SPEED, SCANS), None)  # the same, less clearly said


def _unlike(a: Floats, b: Floats) -> float | None:
    """How far two motions in the plane differ, as a share of the way; None where there is too little of it."""
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


def _look_at_direction(verdicts: Verdicts, moved: list[_Moved], steps: Steps) -> None:
    """Scans that go another way than the twist, as far: the laser is turned, or the twist is."""
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
            text = f"{TWIST} goes across the car where {SCANS} go ahead: it must be in the frame of the car"
            verdicts[pair] = Contradiction("frame", text, found.gross)
    elif abs(angle) > BACKWARD and found is not None:
        text = f"{found.text}, or a laser that looks back and is said to look ahead"
        verdicts[pair] = Contradiction(found.kind, text, found.gross)
    elif NOTABLE_ANGLE < abs(angle) <= BACKWARD:
        side = "left" if angle > 0.0 else "right"
        text = f"{TWIST} goes ahead where {SCANS} go {abs(angle):.0f}° to the {side}: is the laser turned so?"
        verdicts[pair] = Contradiction("direction", text, abs(angle) > GROSS_ANGLE)


def _look_at_wild_turns(verdicts: Verdicts, moved: list[_Moved], steps: Steps, turning: str) -> None:
    """Yaw rates far above all that the car does, also where it hardly turns: degrees, mostly."""
    last = slice(-STANDING_STEPS, None)
    seconds, told = (steps.ends - steps.begins)[last], moved[0].twist[last, 2]
    for reference, turns in ((SCANS, steps.motion[last, 2]), (POSES, moved[0].poses[last, 2])):
        if len(told) < STANDING_STEPS or not (np.isfinite(told).all() and np.isfinite(turns).all()):
            continue
        said, true = (float(np.abs(one).sum() / seconds.sum()) for one in (told, turns))
        if said > WILD_TURN and said > WILD * true:
            text = f"{YAW_RATE}: {turning} says {said:.2f} rad/s where {reference} say {true:.2f} rad/s"
            verdicts[Pair(YAW_RATE, reference)] = Contradiction("unit", f"{text}: {UNITS[YAW_RATE][1]}?", True)


def _look_at_standing(verdicts: Verdicts, moved: list[_Moved], steps: Steps, turning: str) -> None:
    """A twist that moves while the scans stand. On a stand the wheels do, by command."""
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
    """offset: in units of what a car that stands may say."""
    if abs(offset) <= 1.0:
        return None
    why = "do the wheels turn on a stand?" if driven else "does the car stand? calibrate the offset"
    return Contradiction("standing", f"{said} while {SCANS} stand: {why}", abs(offset) > ROLLS and not driven)


def _look_at_commands(verdicts: Verdicts, twist: Floats, steps: Steps) -> None:
    """Commanded and measured speed, while both are steady."""
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
    """Where twist and scans agree it is the poses, or the commands, that are wrong: worth a remark and no more."""
    for pair, found in verdicts.items():
        by_scans = Pair(pair.quantity, SCANS)
        agrees = by_scans in verdicts and verdicts[by_scans] is None
        if found is not None and agrees and pair.reference in (POSES, COMMANDS):
            verdicts[pair] = Contradiction(found.kind, f"{found.text}; the scans agree with the twist", False)
    return verdicts
