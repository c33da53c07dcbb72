"""Robustness sweeps: the table of sweeps, the sudden obstacle, and the command."""

from __future__ import annotations

from pathlib import Path

import pytest

import firstlap
from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.robustness.cases import (
    BY_NAME,
    SWEEPS,
    WAYS,
    Robustness,
    boxes,
    chosen_sweeps,
    stopping_distance,
)
from firstlap.sim.race import OPTION_FIELDS, race, under_conditions

PNG = b"\x89PNG\r\n"


@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_every_sweep_sets_fields_that_exist_to_values_that_they_allow(sweep):
    assert len(set(sweep.values)) == len(sweep.values) >= 5
    assert sweep.sets or sweep.kind == "joints"
    for key in sweep.sets:
        field = OPTION_FIELDS.find(key, "sweep")
        if sweep.kind != "box":
            for value in sweep.values:
                OPTION_FIELDS.check(field, sweep.offset + value * sweep.scale, "sweep")
    for key, value in sweep.fixed:
        OPTION_FIELDS.check(OPTION_FIELDS.find(key, "sweep"), value, "sweep")


def test_the_sweeps_span_what_was_promised():
    spans = {name: (min(sweep.values), max(sweep.values), sweep.unit) for name, sweep in BY_NAME.items()}
    assert spans["lost_beams"] == spans["lost_sectors"] == (0, 60, "%")
    assert spans["range_noise"] == (0, 50, "mm")
    assert spans["pipe_joints"] == (0, 0.8, "m")
    assert spans["scan_rate"] == (10, 40, "Hz")
    assert spans["latency"] == (0, 100, "ms")
    assert spans["speed_measured"] == spans["speed_constant"] == (-20, 20, "%")
    assert set(WAYS) == {"race.obstacle_sight", "race.obstacle_at", "race.obstacle_offset"}


def test_a_sweep_is_conditions_which_change_the_raced_car_and_leave_the_loaded_one_as_it_is():
    car = load_car("default")
    before = car.core.values()
    disturbed = under_conditions(car, BY_NAME["lost_sectors"].conditions(30)).core.values()
    assert disturbed["lidar"]["dropout_block_share"] == pytest.approx(0.3)
    assert disturbed["lidar"]["dropout_block_beams"] == 40
    assert car.core.values() == before
    assert under_conditions(car, BY_NAME["latency"].conditions(50)) is car


def test_the_shortest_stop_grows_with_speed_and_in_bends_and_is_what_the_simulated_car_can_do():
    car = load_car("default")
    stops = [stopping_distance(car, speed, 0.0) for speed in (0.5, 1.0, 2.0, 4.0, 8.0)]
    assert stops == sorted(stops)
    assert stopping_distance(car, 3.0, 5.0) > stopping_distance(car, 3.0, 0.0)
    assert 4.0**2 / (2 * 7.0) < stops[3] < 4.0**2 / (2 * 5.0) + 0.5


def test_boxes_stand_on_the_driven_line_and_appear_from_further_when_told(arena):
    reference = race(arena, "sure", laps=2)
    near, far = (list(boxes(reference, load_car("default"), 5, value)) for value in (1.0, 2.0))
    assert len(near) == len(far) == 15
    for a, b in zip(near, far, strict=True):
        assert (a.s, a.offset) == (b.s, b.offset)
        assert 0.2 < a.sight < b.sight
    middle = near[1]
    line = reference.path
    offset = line["lateral_offset"][abs(line["s"] - middle.s).argmin()]
    assert middle.offset == pytest.approx(offset, abs=0.05)


def test_a_sudden_obstacle_is_seen_in_the_result_and_ends_the_race_of_a_car_that_cannot_stop(arena):
    options = {"obstacle_at": 12.0, "obstacle_sight": 0.05, "obstacle_width": 1.0}
    hit = race(arena, "sure", laps=1, options=options)
    assert hit.outcome == "contact"
    assert hit.contact.obstacle
    assert hit.obstacle.clearance == 0.0
    assert hit.obstacle.speed > 1.0
    assert race(arena, "sure", laps=1).obstacle is None


def test_the_racer_passes_or_stops_on_the_oval_wherever_it_can(cli):
    ran = cli("robustness", "oval", "--sweep", "obstacle", "--places", 2, "--seeds", 1, "--json")
    assert ran.code == 0
    (sweep,) = ran.json["sweeps"]
    assert sweep["contacts"] == []
    for point in sweep["points"]:
        assert point["contact_free"] == 1.0
        assert point["passed"] + point["stopped"] == pytest.approx(point["finished"])
        assert point["runs"] + point["impossible"] + point["before"] == 6


def test_curves_compare_laps_with_the_undisturbed_ones(cli):
    ran = cli("robustness", "oval", "--sweep", "latency", "--laps", 1, "--seeds", 1, "--plot", "a.png", "--json")
    (sweep,) = ran.json["sweeps"]
    assert [point["value"] for point in sweep["points"]] == [0, 20, 40, 60, 80, 100]
    assert sweep["points"][0]["lap_ratio"] == 1.0
    assert sweep["tracks"]["oval"][0]["lap"] == pytest.approx(race(firstlap.load_track("oval"), laps=1).best)
    assert Path("a.png").read_bytes().startswith(PNG)


def test_a_condition_holds_in_every_race_of_a_sweep_and_is_told(cli):
    arguments = ("robustness", "oval", "--sweep", "scan_rate", "--laps", 1, "--seeds", 1)
    plain = cli(*arguments, "--json").json
    slippery = cli(*arguments, "--option", "sensors.speed_scale_error=0.1", "--option", "mu_scale=0.9", "--json").json
    assert plain["options"] == {}
    assert slippery["options"] == {"sensors.speed_scale_error": 0.1, "mu_scale": 0.9}
    assert slippery["sweeps"][0]["tracks"] != plain["sweeps"][0]["tracks"]


def test_a_table_names_every_value(cli):
    ran = cli("robustness", "oval", "--sweep", "scan_rate", "--laps", 1, "--seeds", 1)
    assert ran.code == 0
    assert "scan rate" in ran.out
    assert "contact-free" in ran.out


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("oval", "--sweep", "weather"), "no such sweep"),
        (("nowhere",), "no such track"),
        (("oval", "--seeds", "0"), "seeds"),
        (("oval", "--places", "0"), "places"),
        (("oval", "--plot", "a.txt"), "a.txt"),
        (("oval", "--setup", "slow"), "slow"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(cli, arguments, word):
    ran = cli("robustness", *arguments)
    assert ran.code == 2
    assert word in ran.err
    assert ran.err.count("\n") == 1
    assert ran.out == ""


def test_without_a_finished_reference_lap_there_are_no_obstacles_and_a_note(arena):
    races = Robustness(load_setup("sure").with_assignments(["v_min=9", "v_max=10"]), load_car("default"), 1)
    assert list(races.cases(chosen_sweeps(["obstacle"]), {"arena": arena}, 1, False, 4)) == []
    assert "arena" in races.notes[0]


def test_an_unknown_sweep_names_the_known_ones():
    with pytest.raises(InputError, match="lost_beams"):
        chosen_sweeps(["rain"])
