"""A control for one row of a field table, which asks before it believes its viewer."""

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
"""That a slider has, about."""
LOG_RANGE = 500.0
"""A range with a larger ratio has no use of a slider."""
DIGITS = 6
SETTLE = 0.6
"""[s] without another value after which a large step counts. Who types 0.35 types 0 first, and no car shall have it."""
LEAP = 0.05
"""Of the range: a larger step is a large one."""
HOLD = 1.0
"""[s] after a touch in which nobody else's value moves this control."""
MARK = "● "

Change = Callable[[str, Value], object]
"""key, value; raises InputError, and then nothing has changed."""
Current = Callable[[str], Value]


def step_of(field: Field) -> float:
    """About a 200th of the range, as 1, 2 or 5 times a power of ten."""
    if field.type == "int":
        return 1.0
    rough = (field.max - field.min) / STEPS
    power = 10.0 ** math.floor(math.log10(rough))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= rough * (1.0 - 1e-9))


def shown(value: Value) -> str:
    """For people."""
    return str(value).lower() if isinstance(value, bool) else f"{value:.6g}"


def _widget(gui: viser.GuiApi, field: Field, value: Value, hint: str) -> Any:
    label = f"{field.name} {field.unit}".strip()
    if field.type == "bool":
        return gui.add_checkbox(label, bool(value), hint=hint)
    whole = field.type == "int"
    number = int if whole else float
    low, high, step = number(field.min), number(field.max), number(step_of(field))
    if field.min > 0.0 and field.max / field.min > LOG_RANGE:
        # Without its bounds: the page would take the nearest for what lies outside, and say nothing.
        handle: Any = gui.add_number(label, number(value), step=step, hint=hint)
    else:
        handle = gui.add_slider(label, low, high, step, number(value), hint=hint)
    # The box beside a slider takes values between its steps.
    handle.precision = 0 if whole else DIGITS
    return handle


class Control:
    """One parameter before one viewer."""

    def __init__(self, session: ViewerSession, field: Field, loaded: Value, current: Current, change: Change) -> None:
        self.field = field
        self._session = session
        self._current = current
        self._change = change
        self._label = f"{field.name} {field.unit}".strip()
        self._last = current(field.key)
        self._wrong: Value | None = None
        self._turn = 0
        self._applied = 0
        self._touched = -math.inf
        self._one_by_one = threading.Lock()
        self.handle = _widget(session.gui, field, self._last, "")
        self.load(loaded)
        self.handle.on_update(self._moved)

    @property
    def changed(self) -> bool:
        """Whether it differs from what was loaded."""
        return self._current(self.field.key) != self.loaded

    def load(self, loaded: Value) -> None:
        """Another setup was loaded."""
        self.loaded = loaded
        self.handle.hint = f"{self.field.doc}; {self.field.range}; loaded: {shown(loaded)}"

    def sync(self) -> bool:
        """Shows what is in force; False where its viewer's hand is on it."""
        if time.monotonic() - self._touched < HOLD:
            return False
        self._show()
        return True

    def mark(self) -> None:
        """Shows whether it was changed."""
        assign(self.handle, "label", MARK + self._label if self.changed else self._label)

    def reset(self) -> None:
        """Back to what was loaded. Raises InputError."""
        self._change(self.field.key, self.loaded)
        self._touched = -math.inf

    def matches(self, text: str) -> bool:
        """Whether every word of a search is in its name or doc."""
        about = f"{self.field.key} {self.field.doc}".lower()
        return all(word in about for word in text.lower().split())

    def show(self, visible: bool) -> None:
        """Or hides it."""
        assign(self.handle, "visible", visible)

    async def _moved(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is None:
            return
        self._turn += 1
        turn = self._turn
        self._touched = time.monotonic()
        value = self._meant(event.target.value)
        self._wrong = None if self._is_possible(value) else value
        waits = self._wrong is not None or self._leaps(value)
        self._last = value
        if waits:
            await asyncio.sleep(SETTLE)
        if turn != self._turn:
            return
        refusal = await asyncio.to_thread(self._attempt, turn, value)
        if refusal is None:
            return
        if not waits:
            await asyncio.sleep(SETTLE)
        if turn == self._turn:
            self._give_back(refusal)

    def _meant(self, value: Value) -> Value:
        """On leaving a box, the page puts the nearest possible value for an impossible one: that was not asked for."""
        if self._wrong is not None and value in (self.field.min, self.field.max):
            return self._wrong
        return value

    def _is_possible(self, value: Value) -> bool:
        return isinstance(value, bool) or self.field.min <= value <= self.field.max

    def _leaps(self, value: Value) -> bool:
        if self.field.type == "bool":
            return False
        far = max(LEAP * (self.field.max - self.field.min), 1.5 * step_of(self.field))
        return not abs(value - self._last) <= far

    def _attempt(self, turn: int, value: Value) -> Exception | None:
        with self._one_by_one:
            if turn < self._applied:
                return None
            self._applied = turn
            try:
                self._change(self.field.key, value)
            except Exception as error:
                return error
        return None

    def _give_back(self, refusal: Exception) -> None:
        if isinstance(refusal, InputError):
            self._session.refuse(f"{self.field.name}: refused", str(refusal))
        else:
            self._session.blame(self.field.name, refusal)
        self._wrong = None
        self._touched = -math.inf
        self._show()

    def _show(self) -> None:
        value = self._current(self.field.key)
        self._last = value
        assign(self.handle, "value", value)
