"""The registry entry of the map-based driver. Imports nothing heavy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from firstlap.common.errors import InputError
from firstlap.config.driver_kind import DriverKind, Handle, Preparation, ProgressCallback
from firstlap.drivers.global_driver.params import GLOBAL_FIELDS, GlobalParams

if TYPE_CHECKING:
    from firstlap.config.car_file import Car
    from firstlap.config.setup_file import Setup
    from firstlap.tracks.track import Track


def _make(values: Any, car: Car | None, preparation: Preparation) -> Handle:
    from firstlap.drivers.global_driver.driver import GlobalHandle

    if car is None or preparation.given is None:
        raise InputError("driver global: needs a car and a map of the track")
    return GlobalHandle(values.parts(), car, preparation.given)


def _prepare(track: Track, setup: Setup, car: Car, seed: int, on_progress: ProgressCallback | None) -> Preparation:
    from firstlap.drivers.global_driver.prepare import prepare

    return prepare(track, setup.params(car.core).parts(), car, seed, on_progress)


def global_kind() -> DriverKind:
    """The registry entry."""
    return DriverKind(
        name="global",
        title="map, racing line, particle filter and predictive control",
        fields=GLOBAL_FIELDS,
        new_params=GlobalParams,
        make=_make,
        default_setup="global",
        needs_map=True,
        in_python=True,
        prepare=_prepare,
    )
