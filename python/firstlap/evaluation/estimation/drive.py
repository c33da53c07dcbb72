"""Races with the true, measured and estimated motion at every scan, and the errors of the estimate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import Preparation, driver_kind
from firstlap.config.setup_file import Setup
from firstlap.estimation.columns import COMMANDS, READINGS, estimates_from
from firstlap.evaluation.estimation.cases import Case
from firstlap.sim.race import start_race, under_conditions
from firstlap.tracks.track import Track

Floats = npt.NDArray[np.float64]

ENABLED = {"state_estimate.enabled": 1.0}
TRUE = ("yaw_rate_bias", "acceleration_x_bias", "acceleration_y_bias", "wheel_slip")
"""Estimated constants whose true value is the sensor parameter of the same name."""
LOCKED = 0.7
"""Wheels slower than this share of the car's speed are locked."""
MOVING = 0.5
"""[m/s] At lower speeds, wheels do not count as locked."""


@dataclass(frozen=True)
class Drive:
    """One race under the conditions `case`, driven with the state estimate or with the measured state.

    Columns by name, one entry per scan. readings, estimates: as in the tables of SensorReading and MotionEstimate.
    truth: speed, lateral_speed, yaw_rate, steering_angle. blind: the estimate without the accelerometer.
    """

    case: Case
    outcome: str
    best: float | None
    times: Floats
    readings: dict[str, Floats]
    truth: dict[str, Floats]
    estimates: dict[str, Floats]
    blind: dict[str, Floats]

    @property
    def locked(self) -> npt.NDArray[np.bool_]:
        """(N,) whether the wheels are locked."""
        speed = self.truth["speed"]
        return np.asarray((speed > MOVING) & (self.readings["wheel_speed"] < LOCKED * speed))


def drive(
    track: Track,
    setup: Setup,
    car: Car,
    case: Case,
    *,
    laps: int,
    seed: int,
    estimated: bool = True,
    on_scan: Callable[[_core.Race], object] | None = None,
) -> Drive:
    """Drives one race. Raises InputError.

    estimated: whether the driver is given the state estimate. on_scan: called with the race after every scan.
    """
    handle = driver_kind(setup.driver).make(setup.params(car.core), car, Preparation())
    options = {**case.options, **(ENABLED if estimated else {})}
    race = start_race(track, handle, car, laps=laps, seed=seed, options=options)
    readings, lateral = [], []
    while race.advance():
        readings.append(tuple(race.reading()))
        lateral.append(race.lateral_speed)
        if on_scan:
            on_scan(race)
    found = race.result()
    path = {name: np.asarray(column)[: len(readings)] for name, column in found["path"].items()}
    rows = np.array(readings).reshape(-1, len(READINGS))
    commands = np.column_stack([path[f"command_{name}"] for name in COMMANDS])
    commands = np.vstack([np.zeros_like(commands[:1]), commands])[: len(rows)]
    conditioned = under_conditions(car, case.options).core
    return Drive(
        case=case,
        outcome=found["outcome"],
        best=min((lap.time for lap in found["laps"]), default=None),
        times=np.asarray(path["time"], dtype=np.float64),
        readings=dict(zip(READINGS, rows.T, strict=True)),
        truth={
            "speed": path["speed"],
            "lateral_speed": np.array(lateral),
            "yaw_rate": path["yaw_rate"],
            "steering_angle": path["steering_angle"],
        },
        estimates=estimates_of(conditioned, rows, commands),
        blind=estimates_of(conditioned, without_accelerometer(rows), commands),
    )


def estimates_of(car: _core.Car, readings: Floats, commands: Floats) -> dict[str, Floats]:
    """The estimates by name, (N,) each. readings, commands: (N, K) in the columns READINGS and COMMANDS, at every scan
    and before it."""
    period = 1.0 / float(car.get("lidar", "rate"))  # type: ignore[arg-type]
    return estimates_from(car, readings, commands, np.full(len(readings), period))


def without_accelerometer(readings: Floats) -> Floats:
    """The readings (N, K) of a car without an accelerometer."""
    blind = readings.copy()
    for name in ("acceleration_x", "acceleration_y"):
        blind[:, READINGS.index(name)] = np.nan
    return blind


def rms(error: Floats) -> float | None:
    """Root mean square; None without values."""
    return round(float(np.sqrt(np.mean(error * error))), 5) if len(error) else None


def errors(drives: list[Drive]) -> dict[str, Any]:
    """RMS errors of the measured and the estimated values in races under the same conditions, in SI units."""
    case = drives[0].case
    true = {name: case.options.get(f"sensors.{name}", 0.0) for name in TRUE}
    return {
        "case": case.name,
        "options": dict(case.options),
        "scans": sum(len(one.times) for one in drives),
        "races": len(drives),
        "finished": sum(one.outcome == "finished" for one in drives),
        "speed": {
            **_pair(drives, "speed", "wheel_speed"),
            "without_accelerometer": rms(_joined([one.blind["speed"] - one.truth["speed"] for one in drives])),
        },
        "locked": {
            "scans": sum(int(one.locked.sum()) for one in drives),
            **_pair(drives, "speed", "wheel_speed", locked=True),
        },
        "yaw_rate": _pair(drives, "yaw_rate", "yaw_rate"),
        "steering_angle": _pair(drives, "steering_angle", "steering_angle"),
        "lateral_speed": _pair(drives, "lateral_speed", None),
        **{name: _constant(drives, name, value) for name, value in true.items()},
    }


def _joined(parts: list[Floats]) -> Floats:
    return np.concatenate(parts) if parts else np.zeros(0)


def _pair(drives: list[Drive], name: str, reading: str | None, locked: bool = False) -> dict[str, float | None]:
    """RMS errors of the reading and the estimate of `name`.

    reading: None if no sensor measures it, which counts as a reading of 0. locked: only while the wheels are locked.
    """
    raw, estimated = [], []
    for one in drives:
        where = one.locked if locked else slice(None)
        measured = one.readings[reading] if reading else np.zeros(len(one.times))
        raw.append((measured - one.truth[name])[where])
        estimated.append((one.estimates[name] - one.truth[name])[where])
    return {"raw": rms(_joined(raw)), "estimate": rms(_joined(estimated))}


def _constant(drives: list[Drive], name: str, true: float) -> dict[str, float | None]:
    """The true value of a constant, and the RMS error of its estimate over the second half of each race."""
    halves = [one.estimates[name][len(one.times) // 2 :] for one in drives]
    return {"true": true, "error": rms(_joined(halves) - true)}
