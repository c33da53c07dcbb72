"""firstlap: race an unseen track with a 2D LiDAR.

>>> import firstlap
>>> track = firstlap.load_track("arena")
>>> result = firstlap.race(track, "race", laps=1, seed=1)
>>> result.outcome
'finished'

A name is imported from its module when it is first asked for, so that no part of the package depends on all others
and the command begins at once.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # typing's own, without the time that its import takes
if TYPE_CHECKING:
    from typing import Any

    from firstlap._core import Contact, Lap
    from firstlap.common.errors import InputError
    from firstlap.common.version import __version__
    from firstlap.config.car_file import Car, load_car
    from firstlap.config.setup_file import Setup, list_setups, load_setup
    from firstlap.drivers.racer import Command, Racer
    from firstlap.sim.lidar import Lidar
    from firstlap.sim.race import RaceResult, race
    from firstlap.tracks.library import list_tracks, load_track
    from firstlap.tracks.track import Track

__all__ = [
    "Car",
    "Command",
    "Contact",
    "InputError",
    "Lap",
    "Lidar",
    "RaceResult",
    "Racer",
    "Setup",
    "Track",
    "__version__",
    "list_setups",
    "list_tracks",
    "load_car",
    "load_setup",
    "load_track",
    "race",
]

_MODULES = {
    "firstlap.common.errors": ("InputError",),
    "firstlap.common.version": ("__version__",),
    "firstlap.config.car_file": ("Car", "load_car"),
    "firstlap.config.setup_file": ("Setup", "list_setups", "load_setup"),
    "firstlap.drivers.racer": ("Command", "Racer"),
    "firstlap.sim.race": ("Contact", "Lap", "RaceResult", "race"),
    "firstlap.sim.lidar": ("Lidar",),
    "firstlap.tracks.library": ("list_tracks", "load_track"),
    "firstlap.tracks.track": ("Track",),
}
_OWNERS = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _OWNERS:
        raise AttributeError(f"module 'firstlap' has no attribute {name!r}")
    value = getattr(import_module(_OWNERS[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
