"""Decides when the car must stop; only a person's consent ends a stop. No ROS imports, no own clock.

`Watchdog` is armed by a person (activation, ~/resume). It trips when a source times out, when the node did not run, or
on a stop request; it stays tripped until it is armed again. Times are seconds of any monotonic clock.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

DEADMAN = "deadman"


@dataclass
class Watchdog:
    """timeouts: timeout [s] of each source. pause_limit: maximum time [s] between two calls of `check`."""

    timeouts: Mapping[str, float]
    pause_limit: float = 0.2
    armed: bool = False
    tripped: str = ""
    faults: Counter[str] = field(default_factory=Counter)
    rejected: dict[str, str] = field(default_factory=dict)
    _fed: dict[str, float] = field(default_factory=dict)
    _checked: float | None = None

    def feed(self, source: str, now: float) -> None:
        """Records a valid message."""
        self._fed[source] = now
        self.rejected.pop(source, None)

    def reject(self, source: str, reason: str) -> None:
        """Records a rejected message: it is counted and does not reset the timeout."""
        self.faults[f"{source} rejected"] += 1
        self.rejected[source] = reason

    def silent(self, source: str, now: float) -> float:
        """Time [s] since the last valid message; infinite if there was none."""
        fed = self._fed.get(source)
        return float("inf") if fed is None else now - fed

    def missing(self, now: float) -> str:
        """Which source is missing; empty if none is."""
        for source, limit in self.timeouts.items():
            silent = self.silent(source, now)
            if not silent <= limit:
                why = f" ({self.rejected[source]})" if source in self.rejected else ""
                since = "yet" if silent == float("inf") else f"for {silent:.2f} s"
                return f"no {source} {since}{why}"
        return ""

    def check(self, now: float, steady: float | None = None) -> str:
        """Checks all timeouts; call it periodically. Returns the reason of the stop; empty while the car may drive.

        steady: time [s] of a clock that cannot stop, if `now` is simulated time.
        """
        steady = now if steady is None else steady
        pause = 0.0 if self._checked is None else steady - self._checked
        self._checked = steady
        if not self.armed:
            return self.tripped or "not armed"
        if pause > self.pause_limit:
            return self.trip(f"the node did not run for {pause:.2f} s")
        reason = self.missing(now)
        return self.trip(reason) if reason else ""

    def trip(self, reason: str) -> str:
        """Trips until it is armed again. Returns the reason of the stop: the first one."""
        if self.armed:
            self.faults["stops"] += 1
            self.tripped = reason
        self.armed = False
        return self.tripped or reason

    def arm(self, now: float) -> str:
        """Arms on a person's consent. Returns why it is refused; empty if the car may drive from now on."""
        reason = self.missing(now)
        if reason:
            return reason
        self._checked = None  # the time that arming took is not a pause
        self.armed, self.tripped = True, ""
        return ""

    def disarm(self) -> None:
        """Withdraws the consent."""
        self.armed, self.tripped = False, ""


class DeadMan:
    """A dead-man's switch. Releasing it trips; only a new press is consent, not the return of lost messages."""

    def __init__(self) -> None:
        self.held = False
        self._released = True

    def press(self, held: bool, trusted: bool) -> bool:
        """Whether this message is a new press. trusted: messages arrived without interruption."""
        if not trusted:
            self._released = False
        pressed = held and self._released
        self._released = not held
        self.held = held
        return pressed


def button_of(message: Any, button: int) -> tuple[bool, str]:
    """Whether a std_msgs/Bool (button -1), or this button of a sensor_msgs/Joy, is held; and why that is unknown."""
    if button < 0:
        return bool(message.data), ""
    if button >= len(message.buttons):
        return False, f"no button {button} among {len(message.buttons)}"
    return bool(message.buttons[button]), ""


@dataclass
class Stamps:
    """Checks the stamps of one source [s]. max_age: maximum age; 0: any age."""

    max_age: float
    last: float | None = None

    def reason(self, stamp: float, now: float, took: float = 0.0) -> str:
        """Why a message with this stamp must not be used; empty if it may.

        took: duration of the measurement [s]; the stamp may be its start or its end.
        """
        if self.last is not None and stamp <= self.last:
            before = self.last - stamp
            return f"stamp {before:.3f} s before the last one" if before > 0.0 else "the same stamp again"
        age = now - stamp
        if self.max_age > 0.0 and not -self.max_age <= age <= self.max_age + took:
            return f"stamp {age:.2f} s old" if age > 0.0 else f"stamp {-age:.2f} s in the future"
        return ""

    def take(self, stamp: float) -> None:
        """The stamp of a message that is used: later ones must be after it."""
        self.last = stamp

    def forget(self) -> None:
        """Resets, for a source that restarts."""
        self.last = None


def within(speed: float, steering: float, speed_limit: float, steering_limit: float) -> tuple[float, float] | None:
    """The command clamped to the limits; None if it is not finite: then the car must stop."""
    if not (abs(speed) < float("inf") and abs(steering) < float("inf")):
        return None
    return min(max(speed, 0.0), speed_limit), min(max(steering, -steering_limit), steering_limit)
