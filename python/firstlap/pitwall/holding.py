"""What every source holds: its newest frame, what drives, and what "reset" goes back to."""

from __future__ import annotations

from firstlap.config.setup_file import Setup
from firstlap.pitwall.frame import Frame


class Holding:
    """The part of a `Source` that only looks."""

    def __init__(self, setup: Setup) -> None:
        self._setup = self._loaded = setup
        self._frame: Frame | None = None
        self._number = 0

    def latest(self) -> Frame | None:
        """The newest frame; None before the first. Never waits."""
        return self._frame

    @property
    def setup(self) -> Setup:
        """What drives now."""
        return self._setup

    @property
    def loaded(self) -> Setup:
        """What "reset" goes back to."""
        return self._loaded
