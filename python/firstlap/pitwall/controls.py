"""A control for one row of a field table; it applies a value only once the viewer has settled on it."""

from __future__ import annotations

import asyncio
import math
import threading
import time
from collections.abc import Callable
from typing import Any

import viser

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field, Value
from firstlap.pitwall.viewer_session import ViewerSession, assign

STEPS = 200
"""Approximate number of steps of a slider."""
LOG_RANGE = 500.0
"""A range with a larger ratio gets a number box instead of a slider."""
DIGITS = 6
SETTLING_TIME = 0.6
"""[s] Delay before a large step is applied: whoever types 0.35 types 0 first, which must not reach the car."""
LARGE_STEP = 0.05
"""Fraction of the range above which a step is large."""
HOLD = 1.0
"""[s] After an input, changes by others do not move the control for this time."""
MARK = "● "

Change = Callable[[str, Value], object]
"""Takes key and value; raises InputError, and then nothing has changed."""
Current = Callable[[str], Value]


def step_of(field: Field) -> float:
    """About a 200th of the range, rounded to 1, 2 or 5 times a power of ten."""
    if field.type == "int":
        return 1.0
    rough = (field.max - field.min) / STEPS
    power = 10.0 ** math.floor(math.log10(rough))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= rough * (1.0 - 1e-9))


def shown(value: Value) -> str:
    """Formats a value for display."""
    return str(value).lower() if isinstance(value, bool) else f"{value:.6g}"


def _widget(gui: viser.GuiApi, field: Field, value: Value, hint: str) -> Any:
    label = f"{field.name} {field.unit}".strip()
    if field.type == "bool":
        return gui.add_checkbox(label, bool(value), hint=hint)
    whole = field.type == "int"
    number = int if whole else float
    low, high, step = number(field.min), number(field.max), number(step_of(field))
    if field.min > 0.0 and field.max / field.min > LOG_RANGE:
        # Without bounds: the page would silently clamp values outside of them.
        handle: Any = gui.add_number(label, number(value), step=step, hint=hint)
    else:
        handle = gui.add_slider(label, low, high, step, number(value), hint=hint)
    # The number box of a slider accepts values between its steps.
    handle.precision = 0 if whole else DIGITS
    return handle


class Control:
    """The control of one parameter for one viewer."""

    def __init__(self, session: ViewerSession, field: Field, loaded: Value, current: Current, change: Change) -> None:
        self.field = field
        self._session = session
        self._current = current
        self._change = change
        self._label = f"{field.name} {field.unit}".strip()
        self._last = current(field.key)
        self._invalid: Value | None = None
        self._sequence = 0
        self._applied = 0
        self._touched = -math.inf
        self._one_by_one = threading.Lock()
        self.handle = _widget(session.gui, field, self._last, "")
        self.load(loaded)
        self.handle.on_update(self._moved)

    @property
    def changed(self) -> bool:
        """Whether the value differs from the loaded one."""
        return self._current(self.field.key) != self.loaded

    def load(self, loaded: Value) -> None:
        """Takes a newly loaded value."""
        self.loaded = loaded
        self.handle.hint = f"{self.field.doc}; {self.field.range}; loaded: {shown(loaded)}"

    def sync(self) -> bool:
        """Shows the current value; False if the viewer is using the control."""
        if time.monotonic() - self._touched < HOLD:
            return False
        self._show()
        return True

    def mark(self) -> None:
        """Marks a changed value."""
        assign(self.handle, "label", MARK + self._label if self.changed else self._label)

    def reset(self) -> None:
        """Resets to the loaded value. Raises InputError."""
        self._change(self.field.key, self.loaded)
        self._touched = -math.inf

    def matches(self, text: str) -> bool:
        """Whether name or description contain every word of the search."""
        about = f"{self.field.key} {self.field.doc}".lower()
        return all(word in about for word in text.lower().split())

    def show(self, visible: bool) -> None:
        """Shows or hides the control."""
        assign(self.handle, "visible", visible)

    async def _moved(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is None:
            return
        self._sequence += 1
        sequence = self._sequence
        self._touched = time.monotonic()
        value = self._intended(event.target.value)
        self._invalid = None if self._is_possible(value) else value
        waits = self._invalid is not None or self._is_large_step(value)
        self._last = value
        if waits:
            await asyncio.sleep(SETTLING_TIME)
        if sequence != self._sequence:
            return
        refusal = await asyncio.to_thread(self._attempt, sequence, value)
        if refusal is None:
            return
        if not waits:
            await asyncio.sleep(SETTLING_TIME)
        if sequence == self._sequence:
            self._revert(refusal)

    def _intended(self, value: Value) -> Value:
        """The intended value: when a box loses focus, the page clamps an invalid value, which must not be applied."""
        if self._invalid is not None and value in (self.field.min, self.field.max):
            return self._invalid
        return value

    def _is_possible(self, value: Value) -> bool:
        return isinstance(value, bool) or self.field.min <= value <= self.field.max

    def _is_large_step(self, value: Value) -> bool:
        if self.field.type == "bool":
            return False
        far = max(LARGE_STEP * (self.field.max - self.field.min), 1.5 * step_of(self.field))
        return not abs(value - self._last) <= far

    def _attempt(self, sequence: int, value: Value) -> Exception | None:
        with self._one_by_one:
            if sequence < self._applied:
                return None
            self._applied = sequence
            try:
                self._change(self.field.key, value)
            except Exception as error:
                return error
        return None

    def _revert(self, refusal: Exception) -> None:
        if isinstance(refusal, InputError):
            self._session.refuse(f"{self.field.name}: refused", str(refusal))
        else:
            self._session.report_failure(self.field.name, refusal)
        self._invalid = None
        self._touched = -math.inf
        self._show()

    def _show(self) -> None:
        value = self._current(self.field.key)
        self._last = value
        assign(self.handle, "value", value)
