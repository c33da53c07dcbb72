"""The setup with which a lap was driven."""

from __future__ import annotations

from dataclasses import replace

from firstlap.config.setup_file import Setup
from firstlap.pitwall.controls import shown
from firstlap.pitwall.frame import DrivenLap


class LapSetup:
    """Tracks the setup during a lap and attaches it to the finished lap."""

    def __init__(self) -> None:
        self._setup: Setup | None = None
        self._mixed = False

    def by(self, setup: Setup | None) -> None:
        """Sets the current setup; None if unknown."""
        self._mixed = self._mixed or (self._setup is not None and _differ(self._setup, setup))
        self._setup = setup

    def begin(self) -> None:
        """Starts a lap."""
        self._mixed = False

    def sign(self, lap: DrivenLap) -> DrivenLap:
        """The finished lap with its setup; starts the next lap."""
        signed = replace(lap, setup=self._setup, mixed=self._mixed)
        self.begin()
        return signed


def changed_from(setup: Setup, loaded: Setup) -> Setup:
    """The setup without changes that equal the loaded setup's unchanged values."""
    kept = {
        (section, name): value
        for (section, name), value in setup.changed.items()
        if (section, name) in loaded.changed or value != loaded.get(f"{section}.{name}")
    }
    return replace(setup, changed=kept)


def short(lap: DrivenLap) -> str:
    """Short text for a table: the setup's name, the number of changed values, and "…" if it changed during the lap."""
    if lap.setup is None:
        return ""
    changes = f" +{len(lap.setup.changed)}" if lap.setup.changed else ""
    return f"{'… ' if lap.mixed else ''}{lap.setup.name}{changes}"


def long(lap: DrivenLap) -> str:
    """Full text, such as "setup race; k_ang 0.3, l_max 2; setup changed during the lap"."""
    if lap.setup is None:
        return ""
    changes = ", ".join(f"{name} {shown(value)}" for (_, name), value in sorted(lap.setup.changed.items()))
    return "; ".join(
        part for part in (lap.setup.title, changes, "setup changed during the lap" if lap.mixed else "") if part
    )


def _differ(one: Setup, other: Setup | None) -> bool:
    return other is None or one.driver != other.driver or one.values() != other.values()
