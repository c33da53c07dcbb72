"""Setup and car files: valid content, and error messages for invalid content."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import firstlap
from firstlap import _core
from firstlap.cli import app
from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS, parse_car
from firstlap.config.setup_file import (
    BASE,
    DEFAULT_SETUP,
    LOCAL,
    SETUP_FIELDS,
    choose_setup,
    load_setup,
    parse_setup,
    setups_folder,
)
from firstlap.drivers.driving import Driving
from firstlap.evaluation.published import CHANGES, SETTING_LAPS


@pytest.mark.parametrize("name", firstlap.list_setups())
def test_our_setups_are_valid(name):
    setup = firstlap.load_setup(name)
    assert setup.name == name
    setup.params().validate()


def published() -> dict[int, dict[str, float]]:
    """The table of docs/paper.md: {setting: {parameter or "lap": value}}."""
    page = (Path(__file__).resolve().parents[3] / "docs" / "paper.md").read_text(encoding="utf-8")
    header, _, *rows = [line for line in page.partition("## Published values")[2].splitlines() if line[:1] == "|"]
    settings = [int(cell.removeprefix("setting")) for cell in cells(header)[1:]]
    table: dict[int, dict[str, float]] = {setting: {} for setting in settings}
    for name, *values in map(cells, rows):
        for setting, value in zip(settings, values, strict=True):
            if value:
                table[setting][name.strip("`").removesuffix(" [s]")] = float(value)
    return table


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip("|").split("|")]


def test_base_and_race_carry_the_published_values():
    for setting, setup in ((0, firstlap.load_setup(BASE)), (5, firstlap.load_setup("race"))):
        values = published()[setting]
        assert values.pop("lap") == SETTING_LAPS[setting]
        assert {name: setup.get(name) for name in values} == values


def test_base_states_every_published_value_itself():
    stated = {name for _, name in firstlap.load_setup(BASE).given}
    assert published()[0].keys() - stated == {"lap"}


def test_every_value_of_base_says_whether_it_is_the_papers_or_ours():
    text = (setups_folder() / f"{BASE}.yaml").read_text(encoding="utf-8")
    comments = [line.partition("# ")[2] for line in text.splitlines() if line.startswith("  ")]
    assert len(comments) == len(firstlap.load_setup(BASE).given)
    assert all(comment.startswith(("paper", "ours")) for comment in comments)


def test_the_settings_between_are_the_published_ones():
    between = {setting: values for setting, values in published().items() if setting not in (0, 5)}
    assert {setting: values.pop("lap") for setting, values in between.items()} == {
        setting: SETTING_LAPS[setting] for setting in between
    }
    assert between == CHANGES


def test_the_defaults_of_the_core_are_the_papers_base_setting():
    assert _core.Params().values() == firstlap.load_setup(BASE).values()
    assert all(field.default == firstlap.load_setup(BASE).get(field.key) for field in SETUP_FIELDS.fields)


def test_where_nothing_is_named_the_default_setup_drives():
    default = firstlap.load_setup(DEFAULT_SETUP)
    assert choose_setup(None, None) == choose_setup(LOCAL, None) == default
    assert firstlap.Racer().setup == Driving.of("", "").setup == default
    assert firstlap.race(firstlap.load_track("oval"), laps=1).setup == default


@pytest.mark.parametrize("command", [one for one in app.registered_commands if one.callback], ids=lambda one: one.name)
def test_no_command_has_a_default_setup_of_its_own(command):
    options = inspect.signature(command.callback).parameters
    undecided = (None, inspect.Parameter.empty)
    assert all(options[name].default in undecided for name in options.keys() & {"setup", "setups", "driver"})


def test_the_default_setup_is_named_in_one_place():
    root = Path(firstlap.__file__).parent
    files = [*root.rglob("*.py"), *(root.parents[1] / "ros").rglob("*.py")]
    constants = {
        path.name
        for path in files
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and str(node.value).removesuffix(".yaml") == DEFAULT_SETUP
    }
    assert constants == {"setup_file.py"}


def test_names_are_unique_over_all_sections_so_that_set_needs_none():
    names = [field.name for field in SETUP_FIELDS.fields]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("field", SETUP_FIELDS.fields + CAR_FIELDS.fields, ids=lambda field: field.key)
def test_every_default_lies_in_its_range_and_every_field_says_what_it_is(field):
    assert field.min <= field.default <= field.max
    assert field.doc


def test_a_file_holds_what_differs():
    setup = parse_setup("stanley:\n  k_ang: 0.4\n  rate_reference: 1\nscan:\n  deskew: false\n", "mine.yaml")
    assert setup.name == "mine"
    assert setup.get("k_ang") == 0.4
    assert setup.get("rate_reference") == 1
    assert setup.get("scan.deskew") is False
    assert setup.get("k_dist") == SETUP_FIELDS.find("k_dist", "").default


def test_numbers_that_yaml_takes_for_text_are_numbers():
    assert parse_setup("stanley:\n  k_ang: 4e-1\n", "mine.yaml").get("k_ang") == 0.4


def test_a_changed_copy_leaves_the_first_alone():
    base = firstlap.load_setup("base")
    changed = base.with_values({"k_ang": 0.3})
    assert (base.get("k_ang"), changed.get("k_ang")) == (0.6, 0.3)


def test_a_car_brings_its_body_unless_the_setup_has_one():
    gym = firstlap.load_car("gym").core
    assert firstlap.load_setup("base").params(gym).get("car", "wheelbase") == 0.3302
    own = firstlap.load_setup("base").with_values({"wheelbase": 0.4})
    assert own.params(gym).get("car", "wheelbase") == 0.4


def test_a_car_brings_its_dynamics_to_the_driver_that_knows_of_them():
    nuc2 = firstlap.load_car("nuc2").core
    assert firstlap.load_setup("sure").params(nuc2).get("car", "servo_time_constant") == 0.1578
    assert firstlap.load_setup("sure").params(nuc2).get("car", "steering_delay") == 0.0
    own = firstlap.load_setup("sure").with_values({"car.servo_time_constant": 0.2})
    assert own.params(nuc2).get("car", "servo_time_constant") == 0.2
    assert "servo_time_constant" not in firstlap.load_setup("gap").params(nuc2).values()["car"]


def test_a_setup_that_was_with_car_values_a_car_keeps_to_it_in_another_one():
    nuc2, gym = (firstlap.load_car(name).core for name in ("nuc2", "gym"))
    told = firstlap.load_setup("sure").with_car_values(nuc2)
    assert told.params(gym).values()["car"] == firstlap.load_setup("sure").params(nuc2).values()["car"]
    own = firstlap.load_setup("sure").with_values({"car.speed_delay": 0.1}).with_car_values(nuc2)
    assert own.params(gym).get("car", "speed_delay") == 0.1, "what the setup says itself stays"


def test_the_default_car_is_the_one_that_drivers_believe_in():
    believed, car = firstlap.load_setup("sure").params().values()["car"], firstlap.load_car("default").core.values()
    assert believed == {name: {**car["geometry"], **car["vehicle"]}[name] for name in believed}


def test_a_car_file_holds_what_differs_from_the_default_car():
    car = parse_car("vehicle:\n  friction: 0.6\nlidar:\n  beams: 541\n", "mine.yaml").core
    assert car.get("vehicle", "friction") == 0.6
    assert car.get("lidar", "beams") == 541
    assert car.get("vehicle", "mass") == 3.5


BAD = {
    "empty": ("", "empty|only comments"),
    "only comments": ("# nothing\n", "only comments"),
    "not yaml": ("stanley: [", "not YAML"),
    "no mapping": ("- 1\n", "mine.yaml"),
    "unknown section": ("stanly:\n  k_ang: 1\n", "'stanly'.*stanley"),
    "key without its section": ("k_ang: 1\n", "belongs under stanley"),
    "unknown key": ("stanley:\n  k_andg: 1\n", r"stanley\.k_andg.*stanley\.k_ang"),
    "key of another section": ("stanley:\n  v_max: 1\n", r"stanley\.v_max.*velocity_profile\.v_max"),
    "section is no mapping": ("stanley: 3\n", "stanley"),
    "section is empty": ("stanley:\n", "stanley"),
    "out of range": ("stanley:\n  k_ang: 99\n", r"stanley\.k_ang is 99.*0 to 2"),
    "text": ("stanley:\n  k_ang: fast\n", r"stanley\.k_ang is fast.*not a number"),
    "nothing": ("stanley:\n  k_ang:\n", r"stanley\.k_ang is nothing"),
    "list": ("stanley:\n  k_ang: [1]\n", "not a number"),
    "flag for a number": ("stanley:\n  k_ang: true\n", "not a number"),
    "not finite": ("stanley:\n  k_ang: .nan\n", r"stanley\.k_ang"),
    "infinite": ("stanley:\n  k_ang: .inf\n", r"stanley\.k_ang"),
    "no whole number": ("stanley:\n  rate_reference: 0.5\n", "allowed: an integer"),
    "number for a flag": ("scan:\n  deskew: 2\n", "true or false"),
    "key twice": ("stanley:\n  k_ang: 1\n  k_ang: 0.5\n", "line 3.*given twice"),
    "section twice": ("stanley:\n  k_ang: 1\nstanley:\n  k_dist: 1\n", "given twice"),
    "contradiction": (
        "velocity_profile:\n  v_min: 5\n  v_max: 4.5\n",
        "velocity_profile.v_min is 5, allowed at most velocity_profile.v_max, which is 4.5",
    ),
    "alias": ("stanley: &a\n  k_ang: 1\nscan: *a\n", "alias"),
}


@pytest.mark.parametrize(("text", "reason"), BAD.values(), ids=BAD.keys())
def test_bad_files_are_refused_with_file_name_and_reason(text, reason):
    with pytest.raises(InputError, match=reason) as caught:
        parse_setup(text, "mine.yaml")
    assert "mine.yaml" in str(caught.value)


def test_bad_files_on_disk(tmp_path):
    picture = tmp_path / "picture.yaml"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    for path in (picture, tmp_path, tmp_path / "missing.yaml"):
        with pytest.raises(InputError, match=path.name):
            firstlap.load_setup(path)


def test_axles_that_do_not_fit_the_wheelbase_are_refused():
    with pytest.raises(InputError, match=r"mine\.yaml"):
        parse_car("vehicle:\n  l_f: 1.0\n", "mine.yaml")


@given(st.text(max_size=200))
def test_any_text_is_a_setup_or_refused_in_one_line(text):
    try:
        parse_setup(text, "any.yaml")
    except InputError as error:
        assert "\n" not in str(error)


@given(
    st.sampled_from(SETUP_FIELDS.fields), st.floats() | st.integers() | st.booleans() | st.none() | st.text(max_size=9)
)
def test_any_value_is_in_range_or_refused(field, value):
    try:
        checked = SETUP_FIELDS.check(field, value, "here")
    except InputError:
        return
    assert field.min <= checked <= field.max


def test_a_setup_file_says_for_which_tracks_a_search_found_it(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("tuned_for: my hall\nstanley: {k_ang: 0.5}\n", encoding="utf-8")
    setup = load_setup(path)
    assert (setup.tuned_for, setup.tuning) == ("my hall", "tuned for my hall")
    assert setup.with_values({"k_dist": 1.0}).tuned_for == "my hall"
    assert load_setup("sure").tuning == "untuned"


@pytest.mark.parametrize("value", ["7", "[arena]", "{a: 1}", '"a\\nb"', "x" * 400], ids=repr)
def test_what_a_setup_was_tuned_for_is_a_line_of_text(tmp_path, value):
    path = tmp_path / "mine.yaml"
    path.write_text(f"tuned_for: {value}\nstanley: {{k_ang: 0.5}}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.yaml: tuned_for is .*; expected a track's name"):
        load_setup(path)
