"""What a recording's scans, odometry and commands contradict each other in, for every command that reads one."""

from __future__ import annotations

from firstlap.config.car_file import Car
from firstlap.mapping.direction_of_recording import remarks_on_direction
from firstlap.mapping.odometry_of_recording import remarks_of
from firstlap.recordings import Recording


def contradictions(recording: Recording, car: Car) -> tuple[str, ...]:
    """One line each; none where all agree. car: the laser is taken to sit as the recording says, else as the car has
    it. Raises InputError where no car has it there."""
    return (*remarks_of(recording, car), *remarks_on_direction(recording, car))
