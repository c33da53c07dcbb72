"""When the car must stop, and that nothing but a person lets it go on. Plain Python: no ROS, no clock of its own.

`Watchdog` is armed by a person (activation, ~/resume). It trips when a source falls silent, when the node itself did
not run, or when somebody says stop; a trip stays until it is armed again. Times are seconds of any clock that goes on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

DEADMAN = "deadman"


@dataclass
class Watchdog:
    """timeouts: {source: seconds it may be silent}. pause_limit: [s] between two calls of `check` at most."""

    timeouts: Mapping[str, float]
    pause_limit: float = 0.2
    armed: bool = False
    tripped: str = ""
    faults: Counter[str] = field(default_factory=Counter)
    rejected: dict[str, str] = field(default_factory=dict)
    _fed: dict[str, float] = field(default_factory=dict)
    _checked: float | None = None

    def feed(self, source: str, now: float) -> None:
        """A good message came."""
        self._fed[source] = now
        self.rejected.pop(source, None)

    def reject(self, source: str, reason: str) -> None:
        """A message came that must not be used: it is counted, and does not feed."""
        self.faults[f"{source} rejected"] += 1
        self.rejected[source] = reason

    def silent(self, source: str, now: float) -> float:
        """[s] since the last good message; infinite when there was none."""
        fed = self._fed.get(source)
        return float("inf") if fed is None else now - fed

    def missing(self, now: float) -> str:
        """Why the car may not drive by its sources; empty when it may."""
        for source, limit in self.timeouts.items():
            silent = self.silent(source, now)
            if not silent <= limit:
                why = f" ({self.rejected[source]})" if source in self.rejected else ""
                since = "yet" if silent == float("inf") else f"for {silent:.2f} s"
                return f"no {source} {since}{why}"
        return ""

    def check(self, now: float, steady: float | None = None) -> str:
        """Call often. The reason of the stop; empty while the car may drive.

        steady: of a clock that cannot be stopped, where `now` can (simulated time).
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
        """Stops until somebody arms again. Returns the reason of the stop, which is the first one."""
        if self.armed:
            self.faults["stops"] += 1
            self.tripped = reason
        self.armed = False
        return self.tripped or reason

    def arm(self, now: float) -> str:
        """A person's consent. Returns why it is refused; empty when the car may drive from now on."""
        reason = self.missing(now)
        if reason:
            return reason
        self._checked = None  # how long arming itself took is no pause
        self.armed, self.tripped = True, ""
        return ""

    def disarm(self) -> None:
        """The person takes the consent back."""
        self.armed, self.tripped = False, ""


class DeadMan:
    """A button that must be held. Letting go trips; only a new press, not a message that was lost, is consent."""

    def __init__(self) -> None:
        self.held = False
        self._released = True

    def press(self, held: bool, trusted: bool) -> bool:
        """Whether this message is a fresh press. trusted: the messages before it were not interrupted."""
        if not trusted:
            self._released = False
        fresh = held and self._released
        self._released = not held
        self.held = held
        return fresh


def button_of(message: Any, button: int) -> tuple[bool, str]:
    """Whether a std_msgs/Bool (button -1), or this button of a sensor_msgs/Joy, is held; and why it cannot be told."""
    if button < 0:
        return bool(message.data), ""
    if button >= len(message.buttons):
        return False, f"no button {button} among {len(message.buttons)}"
    return bool(message.buttons[button]), ""


@dataclass
class Stamps:
    """The stamps of one source [s]. max_age: older ones are not used; 0: any age."""

    max_age: float
    last: float | None = None

    def reason(self, stamp: float, now: float, took: float = 0.0) -> str:
        """Why a message with this stamp must not be used; empty when it may.

        took: [s] that was measured for; the stamp may be of its first moment or of its last.
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
        """The source may begin anew."""
        self.last = None


def within(speed: float, steering: float, speed_limit: float, steering_limit: float) -> tuple[float, float] | None:
    """A command within the limits; None where it is not finite, and the car must stop."""
    if not (abs(speed) < float("inf") and abs(steering) < float("inf")):
        return None
    return min(max(speed, 0.0), speed_limit), min(max(steering, -steering_limit), steering_limit)
