"""The public Python API."""

from __future__ import annotations

import ast
import math
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import firstlap
from firstlap import _core

STEERING_LIMIT = 0.4189


def corridor(width: float = 2.0, beams: int = 1081) -> np.ndarray:
    """Ranges in the middle between two parallel walls."""
    angles = np.linspace(-0.75 * math.pi, 0.75 * math.pi, beams)
    with np.errstate(divide="ignore"):
        return np.minimum(0.5 * width / np.abs(np.sin(angles)), 30.0).astype(np.float32)


def test_a_corridor_is_driven_straight():
    racer = firstlap.Racer("base")
    for _ in range(20):
        command = racer.step(corridor(), speed=2.0)
    assert command.status == "ok"
    assert abs(command.steering_angle) < 0.02
    assert command.speed > 0.0


def test_the_trace_shows_the_step_in_numpy():
    racer = firstlap.Racer("base")
    racer.step(corridor(), speed=2.0)
    trace = racer.trace
    assert trace["points"].shape == (len(trace["point_range"]), 2)
    assert np.all(trace["left"]["points"][:, 1] > 0.0)
    assert np.all(trace["right"]["points"][:, 1] < 0.0)
    assert np.allclose(trace["path"]["y"], 0.0, atol=0.05)
    assert trace["result"][2] == "ok"


def test_the_trace_stays_when_the_racer_goes_on():
    racer = firstlap.Racer("base")
    racer.step(corridor(), speed=2.0)
    points = racer.trace["points"]
    before = points.copy()
    racer.step(corridor(3.0), speed=2.0)
    del racer
    assert np.array_equal(points, before)


def test_reset_forgets():
    racer = firstlap.Racer("base")
    first = racer.step(corridor(), speed=2.0)
    racer.step(corridor(1.2), speed=3.0, yaw_rate=0.5)
    racer.reset()
    assert racer.step(corridor(), speed=2.0) == first


def test_a_scan_holds_its_ranges_and_copies_nothing():
    ranges = corridor()
    scan = _core.LaserScan(ranges, -2.35, 0.004)
    assert scan.ranges is ranges
    with pytest.raises(TypeError):
        _core.LaserScan(ranges.astype(np.float64))
    with pytest.raises(TypeError):
        _core.LaserScan(corridor(beams=2162)[::2])


def test_a_scan_has_its_header_in_the_order_of_the_table():
    scan = _core.LaserScan(corridor(), 1.0, 2.0, 3.0, 4.0, 5.0)
    assert scan.header == (1.0, 2.0, 3.0, 4.0, 5.0)
    assert tuple(getattr(scan, column["name"]) for column in _core.LaserScan.columns()) == scan.header


def test_a_scan_with_its_header_is_stepped_like_its_ranges():
    scan = _core.LaserScan(corridor(), angle_min=-2.3, range_max=9.0)
    expected = firstlap.Racer("base").step(corridor(), speed=2.0, angle_min=-2.3, range_max=9.0)
    assert firstlap.Racer("base").step(scan, speed=2.0) == expected


def test_a_state_is_a_value():
    state = _core.VehicleState(1.0, yaw_rate=0.5)
    assert tuple(state) == (1.0, 0.5, 0.0)
    assert state == _core.VehicleState(1.0, 0.5)
    assert state != _core.VehicleState(1.0)
    assert pickle.loads(pickle.dumps(state)) == state
    assert repr(state) == "VehicleState(speed=1.0, yaw_rate=0.5, steering_angle=0.0)"


def test_any_sequence_of_numbers_is_a_scan():
    expected = firstlap.Racer("base").step(corridor(), speed=2.0)
    assert firstlap.Racer("base").step(corridor().astype(np.float64), speed=2.0) == expected
    assert firstlap.Racer("base").step(corridor().tolist(), speed=2.0) == expected


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(width=32), max_size=300) | st.integers(0, 10_000).map(lambda n: [1.0] * n),
    st.floats(),
    st.floats(),
    st.floats(),
    st.floats(),
    st.floats(),
    st.floats(),
)
def test_any_scan_and_state_give_a_finite_limited_command(ranges, speed, yaw_rate, angle, dt, angle_min, increment):
    racer = firstlap.Racer("base")
    racer.step(corridor(), speed=2.0)
    command = racer.step(
        ranges,
        speed=speed,
        yaw_rate=yaw_rate,
        steering_angle=angle,
        dt=dt,
        angle_min=angle_min,
        angle_increment=increment,
    )
    assert 0.0 <= command.speed <= 4.0
    assert abs(command.steering_angle) <= STEERING_LIMIT + 1e-12
    assert command.status in {"ok", "holding", "no_path", "blocked", "bad_scan", "bad_state"}


def test_races_release_the_interpreter(arena):
    """Another thread keeps running while a race is driven in one call."""
    racer = firstlap.Racer("base")
    running = firstlap.race.__globals__["start_race"](arena, racer, firstlap.load_car("default"), laps=1000)
    counted = 0
    driving = threading.Thread(target=lambda: running.advance(20_000))
    driving.start()
    while driving.is_alive():
        counted += 1
        time.sleep(0.001)
    assert counted > 5


def test_a_noise_free_scan_lies_on_the_walls(arena):
    lidar = firstlap.Lidar(arena)
    x, y, yaw = arena.start_pose()
    ranges = lidar.scan(x, y, yaw)
    assert ranges.dtype == np.float32
    assert ranges.shape == lidar.angles.shape == (1081,)
    left = ranges[np.argmin(np.abs(lidar.angles - math.pi / 2))]
    assert left == pytest.approx(arena.width_left[0], abs=0.05)


def test_the_core_is_the_same_version_as_the_package():
    assert firstlap._core.__version__ == firstlap.__version__


def test_field_tables_are_plain_data():
    row = firstlap._core.Params.fields()[0]
    assert set(row) == {"section", "name", "unit", "min", "max", "default", "doc", "type"}


def test_the_core_refuses_what_is_not_in_the_table():
    params = firstlap._core.Params()
    with pytest.raises(KeyError, match=r"stanley\.nothing"):
        params.set("stanley", "nothing", 1.0)
    with pytest.raises(ValueError, match=r"stanley\.k_ang"):
        params.set("stanley", "k_ang", 99.0)
    with pytest.raises(ValueError, match="k_ang"):
        params.set("stanley", "k_ang", math.nan)


def test_every_public_name_is_imported_when_it_is_asked_for():
    tree = ast.parse(Path(firstlap.__file__).read_text(encoding="utf-8"))
    typed = {
        name.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module for name in node.names
    }
    assert typed - {"annotations", "import_module", "Any"} == set(firstlap.__all__)
    for name in firstlap.__all__:
        assert getattr(firstlap, name) is not None
        assert name in dir(firstlap)
    with pytest.raises(AttributeError, match="no attribute 'lap'"):
        firstlap.lap  # noqa: B018


def test_importing_the_package_imports_none_of_its_parts():
    code = "import sys, firstlap; print(sorted(name for name in sys.modules if name.startswith('firstlap.')))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
