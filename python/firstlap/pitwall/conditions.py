"""Conditions of the simulated car and world that can be changed while driving: rows of the core's field tables."""

from __future__ import annotations

from typing import Any

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.parameters import FieldTable, Value

PACE, FRICTION = "view.pace", "world.mu_scale"
LATENCY, COMPUTING = "race.delay_extra", "race.compute_latency"
NOISE, LOST = "lidar.noise_sigma", "lidar.dropout_rate"
DELAYS = ("steering_delay", "speed_delay")
KEYS = (
    FRICTION,
    LATENCY,
    COMPUTING,
    "vehicle.steering_delay",
    "vehicle.speed_delay",
    "vehicle.servo_time_constant",
    NOISE,
    LOST,
    "lidar.dropout_block_rate",
    "lidar.dropout_block_beams",
    "lidar.dropout_block_share",
    "sensors.speed_noise",
    "sensors.speed_scale_error",
    "sensors.yaw_rate_noise",
    "sensors.yaw_rate_bias",
    "sensors.steering_noise",
    "sensors.steering_offset",
    "sensors.latency",
    PACE,
)
OFTEN = (FRICTION, LATENCY, NOISE, LOST, PACE)
PACE_ROW: dict[str, Any] = {
    "section": "view",
    "name": "pace",
    "unit": "",
    "min": 0.1,
    "max": 20.0,
    "default": 1.0,
    "doc": "multiple of real time; slower if the machine cannot keep up",
    "type": "float",
}
PACE_FIELDS = FieldTable([PACE_ROW])


def checked_pace(pace: object, where: str = "--pace") -> float:
    """The playback speed, as a multiple of real time. Raises InputError."""
    return float(PACE_FIELDS.check(PACE_FIELDS.fields[0], pace, where))


class Conditions:
    """Field table and current values. The defaults are those of the loaded car and the given pace."""

    def __init__(self, car: Car, pace: float = 1.0) -> None:
        self.loaded = car
        rows = [
            *_core.WorldOptions.fields(),
            *_core.RaceOptions.fields(),
            *_core.Car.fields(),
            {**PACE_ROW, "default": pace},
        ]
        by_key = {f"{row['section']}.{row['name']}": row for row in rows}
        values = car.core.values()
        self.table = FieldTable(
            {**row, "default": values.get(row["section"], {}).get(row["name"], row["default"])}
            for row in (by_key[key] for key in KEYS)
        )
        self.values: dict[str, Value] = {field.key: field.default for field in self.table.fields}

    def get(self, name: str) -> Value:
        """A value by name or section.name. Raises InputError."""
        return self.values[self.table.find(name, "conditions").key]

    def set(self, name: str, value: object) -> str:
        """Sets a value and returns its key. Raises InputError; then nothing has changed."""
        field = self.table.find(name, "conditions")
        before = self.values[field.key]
        self.values[field.key] = self.table.check(field, value, "conditions")
        try:
            self.car().validate()
        except (InputError, ValueError) as error:
            self.values[field.key] = before
            raise InputError(f"conditions: {error}") from None
        return field.key

    def car(self) -> _core.Car:
        """The loaded car with the current conditions."""
        core = _core.Car(self.loaded.core)
        for field in self.table.fields:
            if field.section in ("vehicle", "lidar", "sensors"):
                core.set(field.section, field.name, self.values[field.key])
        for name in DELAYS:
            row = self.table.find(f"vehicle.{name}", "conditions")
            delay = float(self.values[row.key]) + float(self.values[LATENCY])
            core.set(row.section, name, self.table.check(row, delay, f"with {LATENCY}"))
        return core

    @property
    def pace(self) -> float:
        """Multiple of real time."""
        return float(self.values[PACE])

    @property
    def computing(self) -> float:
        """[s] Compute time of the driver per scan."""
        return float(self.values[COMPUTING])

    @property
    def friction(self) -> float:
        """Scale of the car's friction coefficient."""
        return float(self.values[FRICTION])
