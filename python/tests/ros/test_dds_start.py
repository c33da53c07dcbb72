"""How a driving node is started, and what is looked at before."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.srv import DescribeParameters, GetParameters

import firstlap

pytestmark = pytest.mark.dds

CONFIG = Path(__file__).resolve().parents[3] / "ros" / "firstlap_ros" / "config"


def test_a_parameter_file_is_taken_and_every_parameter_has_its_range_and_description(lab: Any) -> None:
    lab.start("drive", "--no-start", "--ros-args", "--params-file", str(CONFIG / "race.yaml"))
    fields = firstlap.load_setup("race").fields.fields
    names = [field.key for field in fields]
    node = "/firstlap_drive"
    got = lab.probe.call(GetParameters, f"{node}/get_parameters", GetParameters.Request(names=names)).values
    values = firstlap.load_setup("race").values()
    for field, value in zip(fields, got, strict=True):
        taken = {1: value.bool_value, 2: value.integer_value, 3: value.double_value}[value.type]
        assert taken == values[field.section][field.name], field.key
    request = DescribeParameters.Request(names=names)
    described = lab.probe.call(DescribeParameters, f"{node}/describe_parameters", request).descriptors
    for field, one in zip(fields, described, strict=True):
        assert field.doc in one.description
        ranges = [*one.floating_point_range, *one.integer_range]
        assert field.type == "bool" or (ranges[0].from_value, ranges[0].to_value) == (field.min, field.max)


def test_a_wrong_parameter_on_the_command_line_is_one_line(lab: Any) -> None:
    drive = lab.start("drive", "--ros-args", "-p", "velocity_profile.v_max:=99.0")
    lab.until(lambda: drive.process.poll() is not None, "its end")
    assert drive.wait() == 2
    (error,) = [line for line in drive.said.splitlines() if line.startswith("error:")]
    assert "velocity_profile.v_max" in error
    assert "Traceback" not in drive.said


def test_preflight_finds_the_simulated_car_good_and_its_signs_right(lab: Any) -> None:
    lab.start("sim", "arena")
    preflight = lab.start("preflight", "--move", "--yes", "--json")
    lab.until(lambda: preflight.process.poll() is not None, "its end")
    checks = {one["name"]: one for one in json.loads(preflight.said)["checks"]}
    holes = {name for name, one in checks.items() if not one["good"] and "hole" in one["said"]}
    assert {name for name, one in checks.items() if not one["good"]} <= holes, "but for holes of a busy machine"
    assert {"scan", "odometry", "laser's place", "drive"} <= set(checks)
    assert holes or {"drive forward", "turn left"} <= set(checks)


def test_preflight_says_what_is_missing(lab: Any) -> None:
    lab.start("sim", "arena", "--ros-args", "-p", "nan_scans:=true", "-p", "scan_frame:=nowhere")
    preflight = lab.start("preflight", "--json")
    lab.until(lambda: preflight.process.poll() is not None, "its end")
    assert preflight.wait() == 1
    checks = {one["name"]: one for one in json.loads(preflight.said)["checks"]}
    assert "NaN" in checks["scan's beams"]["said"]
    assert "no transform from base_link to nowhere" in checks["laser's place"]["said"]


def test_a_car_with_poor_odometry_drives_by_the_state_estimate(lab: Any, tmp_path: Path) -> None:
    (tmp_path / "poor.yaml").write_text("sensors: {speed_noise: 0.3, yaw_rate_noise: 0.3, yaw_rate_bias: 0.2}\n")
    sim = lab.start("sim", "arena", "--car", "poor.yaml", "--laps", "1", "--json")
    fuse = ("fuse_state:=true", "imu_topic:=sensors/imu/raw", "speed_limit:=3.0")
    noise = ("state_estimate.speed_sigma:=0.3", "state_estimate.yaw_rate_sigma:=0.3")
    lab.start("drive", "--ros-args", *(text for one in (*fuse, *noise) for text in ("-p", one)))

    def over() -> bool:
        if lab.probe.commands["/drive"] and lab.probe.speed() == 0.0:
            lab.probe.trigger("/firstlap_drive/resume")
        lab.probe.spin(0.05)
        return sim.process.poll() is not None

    lab.until(over, "a lap", 120.0)
    (car,) = json.loads(sim.said[sim.said.index("{") :])["cars"]
    assert car["contacts"] == 0
    assert len(car["laps"]) == 1
