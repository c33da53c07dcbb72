"""Mapping lap: a slow lap of the map-less driver in the simulator, mapped from scans and noisy odometry."""

from __future__ import annotations

from collections.abc import Iterator

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, load_car
from firstlap.config.setup_file import LOCAL, Setup, choose_setup
from firstlap.drivers.racer import Racer
from firstlap.mapping.make import SCANS_PER_CALLBACK, MappingProgress, MapResult, finish, mapped, no_loop, no_progress
from firstlap.mapping.observation import Observation, motion_of
from firstlap.mapping.parameters import MapSettings, map_settings
from firstlap.mapping.pose_graph import load_gtsam
from firstlap.mapping.slam import Mapper
from firstlap.perception.scan import laser_of
from firstlap.sim.race import start_race
from firstlap.tracks.track import Track

MANY_LAPS = 1000
HINT = "--set drive.speed=1.5"


def slow(setup: Setup, speed: float) -> Setup:
    """The setup limited to `speed` [m/s]."""
    v_min = min(float(setup.get("v_min")), 0.6 * speed)
    return setup.with_values({"v_max": speed, "v_min": v_min})


class MappingDrive:
    """The drive of a mapping lap, as an iterator over observations; leave the loop to stop."""

    def __init__(self, track: Track, setup: Setup, car: Car, speed: float, seed: int) -> None:
        self.track = track
        self.race = start_race(track, Racer(slow(setup, speed), car), car, laps=MANY_LAPS, seed=seed)

    def __iter__(self) -> Iterator[Observation]:
        last, time = None, 0.0
        while self.race.advance(1):
            state = self.race.measured()
            before = last or state
            dt = self.race.time - time
            speed, rate = 0.5 * (before.speed + state.speed), 0.5 * (before.yaw_rate + state.yaw_rate)
            yield Observation(
                time=self.race.time,
                speed=state.speed,
                yaw_rate=state.yaw_rate,
                motion=motion_of(speed, rate, dt),
                scan=self.race.scan,
            )
            last, time = state, self.race.time
        raise InputError(f"{self.track.name}: the mapping lap failed: {self._end()}; try a slower one: {HINT}")

    def _end(self) -> str:
        found = self.race.result()
        where = f"{self.race.s:.1f} m into lap {self.race.laps_done() + 1}"
        return f"{found['outcome'].replace('_', ' ')}, {where}"


def map_track(
    track: Track,
    setup: Setup | None = None,
    car: Car | None = None,
    *,
    seed: int = 1,
    settings: MapSettings | None = None,
    on_progress: MappingProgress = no_progress,
) -> MapResult:
    """Drives a slow lap in the simulator and makes a map from scans and noisy odometry. Raises InputError."""
    load_gtsam()
    settings, car = settings or map_settings(), car or load_car("default")
    drive = MappingDrive(track, choose_setup(LOCAL, setup), car, settings.get("drive.speed"), seed)
    mapper = Mapper(settings, car.core)

    def going(seen: Mapper) -> bool:
        if seen.traveled > settings.get("drive.give_up"):
            raise InputError(f"{track.name}: {no_loop(seen)} (drive.give_up)")
        if seen.scans % SCANS_PER_CALLBACK == 0:
            on_progress("mapping lap", seen.traveled, track.length + settings.get("drive.overlap"))
        return not seen.closed or seen.overlap < settings.get("drive.overlap")

    return finish(mapped(mapper, drive, going), laser_of(car.core.values()["geometry"]), on_progress)
