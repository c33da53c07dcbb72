"""A slow lap in the simulator: scans and noisy odometry, and never the true pose."""

from __future__ import annotations

from collections.abc import Iterator

from firstlap.car_file import Car
from firstlap.errors import InputError
from firstlap.mapping.observation import Observation, motion_of
from firstlap.race import start_race
from firstlap.racer import Racer
from firstlap.scan import Scan
from firstlap.setup_file import Setup
from firstlap.tracks.track import Track

MANY_LAPS = 1000


def slow(setup: Setup, speed: float) -> Setup:
    """The setup with nothing faster than `speed` [m/s]."""
    v_min = min(float(setup.get("v_min")), 0.6 * speed)
    return setup.with_values({"v_max": speed, "v_min": v_min})


class MappingDrive:
    """The car of a mapping lap: iterate to drive; leave the loop to stop."""

    def __init__(self, track: Track, setup: Setup, car: Car, speed: float, seed: int) -> None:
        self.track = track
        self.race = start_race(track, Racer(slow(setup, speed), car), car, laps=MANY_LAPS, seed=seed)

    def __iter__(self) -> Iterator[Observation]:
        last, time = None, 0.0
        while self.race.advance(1):
            state = self.race.measured()
            before = last or state
            dt = self.race.time - time
            speed, rate = (0.5 * (before[name] + state[name]) for name in ("speed", "yaw_rate"))
            yield Observation(
                time=self.race.time,
                speed=state["speed"],
                yaw_rate=state["yaw_rate"],
                motion=motion_of(speed, rate, dt),
                scan=lambda: Scan(**self.race.scan()),
            )
            last, time = state, self.race.time
        raise InputError(f"{self.track.name}: the mapping lap ended in {self._end()}; a slower one may do: {HINT}")

    def _end(self) -> str:
        found = self.race.result()
        where = f"{self.race.s:.1f} m into lap {self.race.laps_done() + 1}"
        return f"{found['outcome'].replace('_', ' ')}, {where}"


HINT = "--set drive.speed=1.5"
