"""The state that all sources have: newest frame, current setup and loaded setup."""

from __future__ import annotations

from firstlap.config.setup_file import Setup
from firstlap.pitwall.frame import Frame


class SourceState:
    """The read-only part of a `Source`."""

    def __init__(self, setup: Setup) -> None:
        self._setup = self._loaded = setup
        self._frame: Frame | None = None
        self._number = 0

    def latest(self) -> Frame | None:
        """The newest frame; None before the first. Never waits."""
        return self._frame

    @property
    def setup(self) -> Setup:
        """The current setup."""
        return self._setup

    @property
    def loaded(self) -> Setup:
        """The setup that "reset" restores."""
        return self._loaded
