"""Messages of a field table: of the section that was meant, and of the type that is wanted."""

import pytest

from firstlap.common.errors import InputError
from firstlap.config.car_file import CAR_FIELDS


def test_unknown_key_names_the_keys_of_its_own_section():
    with pytest.raises(InputError, match=r"unknown key 'lidar\.qqqq' \(known: beams, beams_vary, fov, "):
        CAR_FIELDS.check_sections({"lidar": {"qqqq": 1}}, "mine.yaml")


def test_a_switch_that_is_neither_says_so():
    with pytest.raises(InputError, match=r"clockwise is maybe, which is neither true nor false; allowed: true or f"):
        CAR_FIELDS.parse_assignment("lidar.clockwise=maybe")


def test_a_name_of_another_section_is_still_found():
    with pytest.raises(InputError, match=r"unknown key 'lidar\.friction' \(did you mean vehicle\.friction\?\)"):
        CAR_FIELDS.check_sections({"lidar": {"friction": 1}}, "mine.yaml")
