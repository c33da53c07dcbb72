"""Error messages of a field table: the intended section and the expected type."""

import pytest

from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS
from firstlap.config.parameters import REMOVED
from firstlap.config.setup_file import SETUP_FIELDS


def test_unknown_key_names_the_keys_of_its_own_section():
    with pytest.raises(InputError, match=r"unknown key 'lidar\.qqqq' \(known: beams, beams_vary, fov, "):
        CAR_FIELDS.check_sections({"lidar": {"qqqq": 1}}, "mine.yaml")


@pytest.mark.parametrize(("name", "instead"), REMOVED.items())
def test_a_former_parameter_is_no_parameter_and_says_what_became_of_it(name, instead):
    assert name not in {field.name for field in SETUP_FIELDS.fields}
    for read in (
        lambda: SETUP_FIELDS.check_sections({"speed_scale": {name: 0.1}}, "mine.yaml"),
        lambda: SETUP_FIELDS.parse_assignment(f"{name}=0.1"),
        lambda: SETUP_FIELDS.find(f"speed_scale.{name}", "log"),
    ):
        with pytest.raises(InputError) as refused:
            read()
        assert f"({name} {instead})" in str(refused.value)


def test_a_switch_that_is_neither_says_so():
    with pytest.raises(InputError, match=r"clockwise is maybe, which is neither true nor false; allowed: true or f"):
        CAR_FIELDS.parse_assignment("lidar.clockwise=maybe")


def test_a_name_of_another_section_is_still_found():
    with pytest.raises(InputError, match=r"unknown key 'lidar\.friction' \(did you mean vehicle\.friction\?\)"):
        CAR_FIELDS.check_sections({"lidar": {"friction": 1}}, "mine.yaml")
