"""Invalid input files: folders, devices, and implausible recordings."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

GOOD = {
    "ranges": np.full((3, 50), 2.0),
    "angle_min": -2.0,
    "angle_increment": 0.08,
    "stamps": np.array([0.0, 0.025, 0.05]),
}


@pytest.mark.parametrize(
    "arguments",
    [
        ("race", "folder"),
        ("race", "oval", "--setup", "folder"),
        ("race", "oval", "--car", "folder"),
        ("survey", "folder"),
        ("check", "folder"),
        ("explain", "--scan", "folder"),
        ("explain", "oval", "--plot", "folder.png"),
        ("race", "map.yaml"),
    ],
    ids=" ".join,
)
def test_a_folder_in_the_place_of_a_file_is_called_one(cli, arguments):
    for name in ("folder", "folder.png"):
        Path(name).mkdir()
    Path("map.yaml").write_text("image: folder\nresolution: 0.05\norigin: [0, 0, 0]\n")
    ran = cli(*arguments)
    assert (ran.code, ran.out) == (2, "")
    assert re.fullmatch(r"error: \S+: (is a|the) folder.+\n", ran.err)


def test_a_device_is_not_read(cli):
    ran = cli("race", "/dev/zero")
    assert (ran.code, ran.out) == (2, "")
    assert "is a device or a pipe" in ran.err


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"angle_min": np.nan}, "'angle_min' is not one finite number"),
        ({"angle_increment": np.inf}, "'angle_increment' is not one finite number"),
        ({"angle_increment": 0.0}, "no valid scan: angle_increment is 0"),
        ({"range_max": -1.0}, "no valid scan: range_max -1 m is not above range_min 0.02 m"),
        ({"ranges": np.zeros((0, 50)), "stamps": np.zeros(0)}, "'ranges' is"),
        ({"ranges": np.zeros((3, 0))}, "'ranges' is"),
    ],
)
def test_a_recording_that_cannot_be_is_refused_in_one_line(cli, changes, says):
    np.savez("scans.npz", **{**GOOD, **changes})
    ran = cli("explain", "--scan", "scans.npz", "--setup", "base")
    assert (ran.code, ran.out) == (2, "")
    assert re.fullmatch(rf"error: scans\.npz: {says}.*\n", ran.err)
    assert not Path("explain.png").exists()


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"stamps": np.array([0.0, 0.05, 0.025])}, "1 backward"),
        ({"stamps": np.array([0.0, 0.025, 0.025])}, "1 repeated"),
        ({"stamps": np.array([0.0, np.nan, 1.0])}, "1 of 3 stamps are not finite"),
    ],
)
def test_wrong_stamps_are_mended_and_said(cli, changes, says):
    np.savez("scans.npz", **{**GOOD, **changes})
    ran = cli("explain", "--scan", "scans.npz", "--setup", "base")
    assert ran.code == 0
    assert says in ran.err


@pytest.mark.parametrize("speed", ["nan", "inf", "-inf", "1e6"])
def test_a_speed_that_cannot_be_is_refused(cli, speed):
    np.savez("scans.npz", **GOOD)
    ran = cli("explain", "--scan", "scans.npz", f"--speed={speed}")
    assert (ran.code, ran.out) == (2, "")
    assert "--speed" in ran.err


def test_a_good_recording_with_lost_beams_is_explained(cli):
    ranges = GOOD["ranges"].copy()
    ranges[:, ::7] = np.nan
    np.savez("scans.npz", **{**GOOD, "ranges": ranges})
    assert cli("explain", "--scan", "scans.npz", "--setup", "base").code == 0
