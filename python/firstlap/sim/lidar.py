"""The simulator's track, and its LiDAR alone."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, load_car
from firstlap.tracks.track import Track

_tracks: WeakKeyDictionary[Track, _core.Track] = WeakKeyDictionary()


def core_track(track: Track) -> _core.Track:
    """The simulator's track; made once, immutable, shared by any number of races."""
    if track not in _tracks:
        try:
            _tracks[track] = _core.Track(**track.to_arrays())
        except ValueError as error:
            raise InputError(f"{track.source or track.name}: {error}") from None
    return _tracks[track]


class Lidar:
    """A car's LiDAR on a track, exact and without noise."""

    def __init__(self, track: Track, car: str | Car = "default") -> None:
        self.car = car if isinstance(car, Car) else load_car(car)
        self._core = _core.Lidar(core_track(track), self.car.core)

    @property
    def angles(self) -> npt.NDArray[np.float64]:
        """(beams,) angle of each beam in the LiDAR's frame [rad], right to left."""
        lidar = self.car.core.values()["lidar"]
        return np.linspace(-lidar["fov"] / 2, lidar["fov"] / 2, int(lidar["beams"]))

    def scan(self, x: float, y: float, yaw: float) -> npt.NDArray[np.float32]:
        """(beams,) ranges [m] from the LiDAR's pose in the map frame [m, rad]; +inf for no return."""
        return self._core.scan(x, y, yaw)
