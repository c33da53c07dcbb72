"""Which setup drove a lap."""

from __future__ import annotations

from dataclasses import replace

from firstlap.config.setup_file import Setup
from firstlap.pitwall.controls import shown
from firstlap.pitwall.frame import DrivenLap


class LapSetup:
    """Tell it what drives; ask it at the end of each lap."""

    def __init__(self) -> None:
        self._setup: Setup | None = None
        self._mixed = False

    def by(self, setup: Setup | None) -> None:
        """From now on; None where nobody knows."""
        self._mixed = self._mixed or (self._setup is not None and _differ(self._setup, setup))
        self._setup = setup

    def begin(self) -> None:
        """A lap begins."""
        self._mixed = False

    def sign(self, lap: DrivenLap) -> DrivenLap:
        """The lap that ends here with what drove it; the next one begins."""
        signed = replace(lap, setup=self._setup, mixed=self._mixed)
        self.begin()
        return signed


def changed_from(setup: Setup, loaded: Setup) -> Setup:
    """The setup with only those of its changes that still differ from what was loaded, or were changed there."""
    kept = {
        (section, name): value
        for (section, name), value in setup.changed.items()
        if (section, name) in loaded.changed or value != loaded.get(f"{section}.{name}")
    }
    return replace(setup, changed=kept)


def short(lap: DrivenLap) -> str:
    """For a table: the setup's name, how many values were changed, and whether that happened on the way."""
    if lap.setup is None:
        return ""
    changes = f" +{len(lap.setup.changed)}" if lap.setup.changed else ""
    return f"{'… ' if lap.mixed else ''}{lap.setup.name}{changes}"


def long(lap: DrivenLap) -> str:
    """For who asks: "setup race; k_ang 0.3, l_max 2; something else drove its begin"."""
    if lap.setup is None:
        return ""
    changes = ", ".join(f"{name} {shown(value)}" for (_, name), value in sorted(lap.setup.changed.items()))
    return "; ".join(
        part for part in (lap.setup.title, changes, "something else drove its begin" if lap.mixed else "") if part
    )


def _differ(one: Setup, other: Setup | None) -> bool:
    return other is None or one.driver != other.driver or one.values() != other.values()
