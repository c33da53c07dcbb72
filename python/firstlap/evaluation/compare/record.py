"""Records of races and their store, so that an interrupted comparison can be resumed."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap._core import Lap
from firstlap.common.cache import code_hash
from firstlap.common.errors import InputError
from firstlap.common.files import write_whole
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.setup_file import Setup
from firstlap.sim.race import RaceResult
from firstlap.tracks.track import Track
from firstlap.tracks.track_hash import track_hash

COLUMNS = ("time", "x", "y", "speed", "s")
Line = dict[str, npt.NDArray[np.float64]]


@dataclass(frozen=True)
class Record:
    """One race of a comparison.

    path: columns (time, x, y, speed, s) at the scans, map frame and SI. compute_times: (steps,) microseconds.
    """

    seed: int
    outcome: str
    time: float
    distance: float
    laps: list[Lap]
    contact: bool
    skipped_scans: int
    compute_times: npt.NDArray[np.float32]
    path: Line

    @property
    def finished(self) -> bool:
        """Whether all laps were driven."""
        return self.outcome == "finished"

    @property
    def flying(self) -> list[Lap]:
        """The flying laps; the standing-start lap if it is the only one."""
        return [lap for lap in self.laps if not lap.standing] or self.laps

    def line_of_best_lap(self) -> Line | None:
        """The path of its fastest flying lap; None without a complete lap."""
        if not self.laps:
            return None
        ends = np.cumsum([lap.time for lap in self.laps])
        i = min((lap.time, i) for i, lap in enumerate(self.laps) if lap in self.flying)[1]
        inside = (self.path["time"] >= ends[i] - self.laps[i].time) & (self.path["time"] <= ends[i])
        return {name: column[inside] for name, column in self.path.items()}


def to_record(result: RaceResult) -> Record:
    """Makes the record of a race."""
    return Record(
        seed=result.seed,
        outcome=result.outcome,
        time=result.time,
        distance=result.distance,
        laps=result.laps,
        contact=result.contact is not None,
        skipped_scans=result.skipped_scans,
        compute_times=result.compute_times,
        path={name: np.asarray(result.path[name], dtype=np.float64) for name in COLUMNS},
    )


class Store:
    """A folder with one file per race, named by a hash of everything that the race depends on."""

    def __init__(self, folder: Path) -> None:
        """Creates the folder. Raises InputError."""
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot create the folder for races ({error.strerror})") from None
        if not os.access(folder, os.W_OK):
            raise InputError(f"{folder}: cannot be written")

    def load(self, key: str) -> Record | None:
        """The race stored under a key; None if there is none or it cannot be read."""
        try:
            with np.load(self.folder / f"{key}.npz", allow_pickle=False) as file:
                facts = json.loads(str(file["facts"]))
                facts["laps"] = [Lap(**lap) for lap in facts["laps"]]
                path = {name: file[name] for name in COLUMNS}
                return Record(**facts, compute_times=file["compute_times"], path=path)
        except FileNotFoundError:
            return None
        except Exception:  # a file of another version, or incomplete after a crash: race again
            return None

    def save(self, key: str, record: Record) -> None:
        """Stores a race. Raises InputError."""
        facts = {
            name: getattr(record, name) for name in ("seed", "outcome", "time", "distance", "contact", "skipped_scans")
        }
        facts["laps"] = [lap.to_dict() for lap in record.laps]
        arrays: dict[str, Any] = {"facts": json.dumps(facts), "compute_times": record.compute_times, **record.path}
        write_whole(self.folder / f"{key}.npz", lambda name: np.savez_compressed(name, **arrays))


def race_key(
    track: Track, setup: Setup, car: Car, laps: int, seed: int, latency: str, options: Mapping[str, float]
) -> str:
    """Hash of everything that a race depends on: code, track, setup, car, laps, seed, latency, conditions."""
    said = {
        "version": __version__,
        "code": code_hash(driver_kind(setup.driver).in_python),
        "track": track_hash(track),
        "driver": setup.driver,
        "setup": setup.params(car.core).values(),
        "car": car.core.values(),
        "laps": laps,
        "seed": seed,
        "latency": latency,
        "options": dict(options),
    }
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:40]
