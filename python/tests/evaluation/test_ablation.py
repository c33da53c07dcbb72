"""The ablation: every rule has values that turn it off; a run can be interrupted and resumed."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import pytest

from firstlap.common.errors import InputError
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.ablation.measure import REFERENCE, Ablation, Plan
from firstlap.evaluation.ablation.rules import RULES, additions, chosen_rules, together
from firstlap.tracks.library import load_track


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_every_rule_is_on_in_one_of_the_setups_and_can_be_turned_off(rule):
    core = load_car("default").core
    setups = [load_setup(name) for name in ("sure", "brisk", "base")]
    changed = [setup.with_assignments(rule.assignments) for setup in setups]
    assert any(off.params(core).values() != on.params(core).values() for off, on in zip(changed, setups, strict=True))


def test_names_are_unique_and_an_unknown_one_is_said():
    assert len({rule.name for rule in RULES}) == len(RULES)
    assert chosen_rules(["join"])[0].off == "join_distance=0"
    with pytest.raises(InputError, match="no such rule"):
        chosen_rules(["luck"])


@pytest.fixture
def plan():
    track = load_track("oval")
    return Plan([load_setup("sure")], {"oval": track}, [], [], [])


def test_a_rule_is_raced_against_all_rules_and_a_state_file_saves_racing_again(plan, tmp_path):
    state = tmp_path / "state.jsonl"
    first = Ablation(plan, load_car("default"), chosen_rules(["join"]), state)
    first.run()
    rows = first.to_dict()["rules"]
    assert [row["rule"] for row in rows] == [REFERENCE, "join"]
    assert rows[0]["race"] == {"passed": 2, "cases": 2}
    assert rows[0]["lap_ratio"] == 1.0
    assert rows[1]["lap_ratio"] != 1.0

    def never(*_args, **_options):
        raise AssertionError("measured again")

    again = Ablation(plan, load_car("default"), chosen_rules(["join"]), state)
    again._race = never
    again.run()
    assert again.to_dict() == first.to_dict()


def test_a_state_file_of_a_larger_plan_counts_only_what_is_planned(plan, tmp_path):
    state = tmp_path / "state.jsonl"
    car = load_car("default")
    Ablation(replace(plan, seeds=2), car, chosen_rules(["join"]), state).run()
    smaller = Ablation(plan, car, chosen_rules(["join"]), state)
    smaller.run()
    assert [row["race"]["cases"] for row in smaller.to_dict()["rules"]] == [2, 2]


def test_a_rule_that_a_setup_has_off_is_not_measured_and_counts_as_all_rules(plan):
    study = Ablation(plan, load_car("default"), chosen_rules(["minimum-curvature path"]))
    assert {job.rule for job in study.jobs()} == {REFERENCE}
    study.run()
    assert study.to_dict()["rules"][1]["lap_ratio"] == 1.0


def test_a_damaged_state_file_is_said(plan, tmp_path):
    state = tmp_path / "state.jsonl"
    state.write_text("{}\nno\n")
    with pytest.raises(InputError, match="is not a state file of an ablation"):
        Ablation(plan, load_car("default"), [], state).run()


def test_the_command_prints_json_and_skips_a_recording_that_is_not_there(cli, tmp_path):
    ran = cli("ablation", "oval", "--rule", "gap width score", "--setup", "sure", "--quick", "--json")
    found = json.loads(ran.out)
    assert [row["rule"] for row in found["rules"]] == [REFERENCE, "gap width score"]
    missing = tmp_path / "none.npz"
    skipped = cli(
        "ablation",
        "oval",
        "--rule",
        "deskew",
        "--setup",
        "sure",
        "--disturbed",
        "0",
        "--perceived",
        "0",
        "--recording",
        missing,
    )
    assert f"skipped: {missing}" in skipped.err
    assert cli("ablation", "oval", "--rule", "luck").code == 2
    assert "--together: which rules?" in cli("ablation", "oval", "--together").err


def test_rules_off_together_are_one_row():
    both = together(chosen_rules(["join", "Opheim"]))
    assert both.assignments == ["join_distance=0", "opheim_min=0"]
    assert both.lines == sum(rule.lines for rule in chosen_rules(["join", "Opheim"]))


def test_the_additions_lead_from_the_paper_to_base_one_by_one():
    paper, base = load_setup("paper_base"), load_setup("base")
    rows = additions(paper, base)
    core = load_car("default").core
    sizes = [len(row.assignments) for row in rows]
    assert sizes == sorted(sizes)
    assert len(set(sizes)) == len(sizes)
    assert paper.with_assignments(rows[-1].assignments).params(core).values() == base.params(core).values()
    for before, row in itertools.pairwise(rows):
        assert set(before.assignments) < set(row.assignments)


KEPT = {
    "body mask": "the car's own body is no wall, whatever the method",
    "one-sided split penalty": "the paper selects sides by pose, and says not how",
    "maximum gap in a wall": "the paper's elimination by distance, within one side",
    "other splits only if the first is short": "of several candidates, of which there is one",
    "width: ignore wide pairs": "the paper's range of widths",
    "wall end supports nothing beyond it": "how a side is representative, which the paper leaves open",
}
"""Rules that are on in the paper's setups, and why."""


@pytest.mark.parametrize("name", ["paper_base", "paper_race"])
def test_the_papers_setups_have_every_other_addition_off(name):
    setup = load_setup(name)
    off = {rule.name: setup.with_assignments(rule.assignments) for rule in RULES if not rule.published}
    core = load_car("default").core
    on = {rule for rule, without in off.items() if without.params(core).values() != setup.params(core).values()}
    assert on - {"third split candidate"} == set(KEPT)


def test_from_paper_goes_its_own_way(cli):
    said = cli("ablation", "oval", "--from-paper", "--setup", "sure")
    assert said.code == 2
    assert "it goes from paper_base to base" in said.err
