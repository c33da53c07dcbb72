"""firstlap: race an unseen track with a 2D LiDAR.

>>> import firstlap
>>> track = firstlap.load_track("arena")
>>> result = firstlap.race(track, "race", laps=1, seed=1)
>>> result.outcome
'finished'
"""

from importlib.metadata import version

from firstlap.car_file import Car, load_car
from firstlap.errors import InputError
from firstlap.race import Contact, Lap, RaceResult, race
from firstlap.racer import Command, Racer
from firstlap.setup_file import Setup, list_setups, load_setup
from firstlap.simulate import Lidar
from firstlap.tracks.library import list_tracks, load_track
from firstlap.tracks.track import Track

__version__ = version("firstlap")

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
    "list_setups",
    "list_tracks",
    "load_car",
    "load_setup",
    "load_track",
    "race",
]
