"""Direction of travel: scans that contradict the commands reveal a wrong LiDAR mounting."""

from __future__ import annotations

from pathlib import Path

import bags
import pytest

from firstlap import load_car, load_setup, load_track, race
from firstlap.evaluation.replay.replay import replay
from firstlap.mapping.direction_of_recording import remarks_on_direction
from firstlap.recordings import Recording, Topics, load_recording
from firstlap.recordings.laser import parse_laser

SCANS = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "scans"
needs_scans = pytest.mark.skipif(not SCANS.is_dir(), reason="the real recordings (../shared/data) are not here")


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Some seconds of a race on a winding track."""
    path = tmp_path_factory.mktemp("drive") / "a.mcap"
    car = load_car("default")
    car.core.set("lidar", "sweep_time", 0.0)
    race(load_track("arena"), "sure", car, laps=1, record=path)
    return load_recording(path).between(1.0, 6.0)


@pytest.mark.parametrize(("mounted", "side"), [(150.0, ""), (90.0, "right"), (-120.0, "left")])
def test_a_laser_that_is_mounted_otherwise_is_said_with_its_yaw(
    drive: Recording, tmp_path: Path, mounted: float, side: str
) -> None:
    path = bags.as_mounted(drive, (0.27, 0.0, mounted, 0.0), tmp_path / "a", tf=False, odom=False)
    (remark,) = replay(load_recording(path), load_setup("sure"), load_car("default")).remarks[-1:]
    assert "the car drives forward by its commands (/drive)" in remark
    assert f"{side} of that by its scans" in remark
    yaw = float(remark.rpartition(" ")[2])
    assert abs((yaw - mounted + 180.0) % 360.0 - 180.0) < 15.0
    told = load_recording(path, Topics(laser=parse_laser(f"0.27,0,{mounted}")))
    assert remarks_on_direction(told, load_car("default")) == ()


def test_nothing_is_said_where_all_agree_or_odometry_tells(drive: Recording, tmp_path: Path) -> None:
    agree = load_recording(bags.as_mounted(drive, (0.27, 0.0, 0.0, 0.0), tmp_path / "a", odom=False))
    assert remarks_on_direction(agree, load_car("default")) == ()
    measured = load_recording(bags.as_mounted(drive, (0.27, 0.0, 150.0, 0.0), tmp_path / "b", tf=False))
    assert remarks_on_direction(measured, load_car("default")) == ()  # that is part of the odometry check


@needs_scans
@pytest.mark.parametrize("name", ["straight_1_speed_1", "sinside_corner_1_speed_1"])
def test_real_cars_drive_ahead_and_a_laser_that_is_said_to_be_turned_is_found(name: str) -> None:
    path = SCANS / name / "rosbag2"
    assert remarks_on_direction(load_recording(path), load_car("default")) == ()
    turned = load_recording(path, Topics(laser=parse_laser("0.27,0,120")))
    (remark,) = remarks_on_direction(turned, load_car("default"))
    assert abs(float(remark.rpartition(" ")[2])) < 15.0
