"""The paper's settings: what changes from one to the next, what does not, and `firstlap tune --paper`."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import firstlap
from firstlap.config.setup_file import SETUP_FIELDS, list_setups, load_setup
from firstlap.evaluation.published import CHANGES, FIRST, LAST, NOT_ROBUST, PUBLISHED, SETTING_LAPS
from firstlap.paper.settings import NOT_ROBUST_RAISED, RAISED, interpolate, paper_settings, silent_fields

QUICK = ("tune", "arena", "--paper", "--seeds", 1)


def test_the_settings_have_what_the_paper_prints():
    settings = paper_settings()
    assert len(settings) == 7
    for name in PUBLISHED:
        assert settings[0].get(name) == load_setup(FIRST).get(name)
        assert settings[5].get(name) == load_setup(LAST).get(name)
    for place, changes in CHANGES.items():
        for name, value in changes.items():
            assert settings[place].get(name) == value
    assert settings[5].get(RAISED) == load_setup(LAST).get(RAISED)
    assert settings[NOT_ROBUST].get(RAISED) == NOT_ROBUST_RAISED
    assert {name: settings[6].get(name) for name in PUBLISHED} == {name: settings[5].get(name) for name in PUBLISHED}


@pytest.mark.parametrize("start", list_setups("local"))
def test_nothing_but_the_cornering_limit_changes_that_the_paper_does_not_print(start):
    settings = paper_settings(load_setup(start))
    for field in SETUP_FIELDS.fields:
        if field.name not in PUBLISHED and field.key != RAISED:
            assert {one.get(field.key) for one in settings} == {load_setup(start).get(field.key)}, field.key


def test_with_published_parameters_alone_no_other_changes_and_there_is_no_seventh_setting():
    settings = paper_settings(published_only=True)
    assert len(settings) == 6
    for field in silent_fields(settings[0]):
        assert {one.get(field.key) for one in settings} == {load_setup(FIRST).get(field.key)}, field.key


def test_a_change_is_in_every_setting():
    settings = paper_settings(changes=["friction_ellipse=true", "k_dist=1"])
    assert {one.get("friction_ellipse") for one in settings} == {True}
    assert {one.get("k_dist") for one in settings} == {1.0}


@pytest.mark.parametrize("field", SETUP_FIELDS.fields, ids=lambda field: field.key)
def test_switches_choices_counts_and_what_zero_turns_off_are_never_interpolated(field):
    low, high = field.min, field.max
    if field.type == "float" and low * high > 0.0:
        assert low < interpolate(field, low, high, 0.5) < high
    if field.type != "float":
        with pytest.raises(ValueError, match=re.escape(field.key)):
            interpolate(field, field.min, field.max, 0.5)
    else:
        with pytest.raises(ValueError, match=re.escape(field.key)):
            interpolate(field, 0.0, 1.0, 0.5)


def test_a_setup_of_another_driver_is_refused():
    with pytest.raises(firstlap.InputError, match="driver gap"):
        paper_settings(load_setup("gap"))


def test_the_settings_are_driven_and_the_output_says_what_the_paper_does_not(cli):
    said = cli(*QUICK, "--json")
    assert said.code == 0, said.err
    found = said.json
    assert [row["paper_lap"] for row in found["settings"]] == [SETTING_LAPS.get(place) for place in range(7)]
    laps = [row["lap"] for row in found["settings"]]
    assert laps[5] < laps[4] < laps[2] < laps[0]
    assert [row["robust"] for row in found["settings"]] == [True] * 6 + [False]
    assert all((row["races"], row["varied_races"]) == (1, 1) for row in found["settings"])
    assert len(set(found["silent"][RAISED])) == 7
    assert found["silent"]["velocity_profile.friction_ellipse"] == [False] * 7
    page = Path(found["report"]).read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 3
    for word in ("finished with spread", "trajectory.smoothing_iterations", RAISED):
        assert word in page
    assert json.dumps(found)


def test_published_only_set_reverse_and_judge_work_with_it(cli):
    said = cli(*QUICK, "--published-only", "--set", "smoothing_iterations=20", "--reverse", "--judge", "friction=0.2")
    assert said.code == 0, said.err
    words = " ".join(said.out.split())
    assert "smoothing_iterations 20" in words
    assert "a_y_max 2.3;" in words


REFUSED = {
    "--only": ("--only", "k_ang"),
    "--fix": ("--fix", "k_ang"),
    "--budget": ("--budget", "3m"),
    "--starts": ("--starts", "none"),
    "--driver": ("--driver", "gap"),
    "--seed": ("--seed", "2"),
    "--name": ("--name", "a"),
    "--study": ("--study", "a.db"),
    "--also": ("--also", "arena"),
    "--validate": ("--no-validate",),
    "--cluster": ("--cluster", "tcp://127.0.0.1:1"),
    "--population": ("--population", "8"),
    "--judge margin": ("--judge", "margin=0.08"),
}


@pytest.mark.parametrize(("option", "arguments"), REFUSED.items(), ids=REFUSED.keys())
def test_an_option_without_effect_is_refused(cli, option, arguments):
    said = cli("tune", "oval", "--paper", *arguments)
    assert said.code == 2
    assert re.fullmatch(rf"error: {option}: has no effect with --paper.*\n", said.err)


@pytest.mark.parametrize("arguments", [("--set", "k_ang=0.3"), ("--published-only",)], ids=lambda a: a[0])
def test_an_option_of_paper_alone_is_refused_without_it(cli, arguments):
    said = cli("tune", "oval", *arguments)
    assert said.code == 2
    assert re.fullmatch(rf"error: {arguments[0]}: has no effect without --paper; .*\n", said.err)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--set", "k_ang=9"), "--set: stanley.k_ang is 9; allowed: 0 to 2"),
        (("--set", "v_min=9"), "v_min"),
        (("--from", "gap"), "driver gap"),
        (("--from", "nothing"), "no such setup"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(cli, arguments, words):
    said = cli("tune", "oval", "--paper", *arguments)
    assert said.code == 2
    assert re.fullmatch(r"error: .+\n", said.err)
    assert words in said.err
