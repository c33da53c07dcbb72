"""A car without valid scans for a moment: it holds its path by odometry, and the stopping check uses the carried-over
walls."""

from __future__ import annotations

import numpy as np
import pytest

import firstlap
from firstlap import _core
from firstlap.config.car_file import load_car
from firstlap.config.driver_kind import CoreHandle
from firstlap.config.setup_file import load_setup
from firstlap.sim.race import start_race

SEEN = 3
"""Number of scans that show the box before the invalid ones."""
BLIND = 7
"""Number of consecutive invalid scans; shorter than the hold time."""
NEAREST = 0.3
"""[m] Minimum distance from the box."""


class Blinded:
    """A racer that gets invalid scans after a box has been visible for a moment; for `_core.CallbackDriver`."""

    def __init__(self, setup: str, blind: int) -> None:
        self.racer = _core.Racer(load_setup(setup).params(load_car("default").core))
        self.blind = blind
        self.race: _core.Race | None = None
        self.shown = 0
        self.holding = 0

    def reset(self) -> None:
        self.racer.reset()

    def step(self, scan, state, dt):
        assert self.race is not None
        self.shown += self.race.result()["obstacle"] is not None
        if SEEN < self.shown <= SEEN + self.blind:
            scan = _core.LaserScan(np.zeros_like(scan.ranges), *scan.header)
        result = self.racer.step(scan, state, dt)
        self.holding += result[2] == "holding"
        return result


def end_before_a_box(setup: str, sight: float, blind: int) -> tuple[str, float, int]:
    """Outcome of a race with a box across the track, smallest distance to the box, and number of scans with status
    holding."""
    driver = Blinded(setup, blind)
    options = {"obstacle_at": 60.0, "obstacle_sight": sight, "obstacle_width": 2.4, "obstacle_length": 0.1}
    race = start_race(
        firstlap.load_track("oval"),
        CoreHandle(_core.CallbackDriver(driver)),
        load_car("default"),
        laps=2,
        options=options,
    )
    driver.race = race
    while race.advance():
        pass
    found = race.result()
    return found["outcome"], found["obstacle"].clearance, driver.holding


@pytest.mark.parametrize("setup", ["sure", "brisk"])
def test_a_car_whose_scans_go_bad_before_a_box_stops_before_it(setup):
    for sight in (3.5, 4.0, 5.0, 6.0):
        outcome, clearance, holding = end_before_a_box(setup, sight, BLIND)
        assert outcome == "stuck", sight
        assert clearance > NEAREST, sight
        assert holding >= BLIND - 1
