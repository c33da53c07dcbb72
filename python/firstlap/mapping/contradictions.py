"""Contradictions between a recording's scans, odometry and commands, for all commands that read recordings."""

from __future__ import annotations

from firstlap.config.car_file import Car
from firstlap.mapping.direction_of_recording import remarks_on_direction
from firstlap.mapping.odometry_of_recording import remarks_of
from firstlap.recordings import Recording


def contradictions(recording: Recording, car: Car) -> tuple[str, ...]:
    """One line per contradiction. car: its LiDAR mounting is used if the recording has none. Raises InputError if the
    recorded mounting is out of range."""
    return (*remarks_of(recording, car), *remarks_on_direction(recording, car))
