"""Real-world LiDARs: slow ones, ones with a varying number of beams, ones that stamp the end of the sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

pytestmark = pytest.mark.dds

CALM = ("--ros-args", "-p", "odom_timeout:=1.0", "-p", "pause_limit:=1.0")
"""Long timeouts except that of the scans, so that a busy machine does not stop the car."""
FAULTS: dict[str, dict[str, Any]] = {
    "as it should be": {},
    "stamps of the last beam": {"end_stamps": True},
}


class Rolls:
    """Counts the scans of a moving car."""

    def __init__(self, truth: list[Any]) -> None:
        self._truth, self._from = truth, len(truth)

    def scans(self) -> int:
        """The count so far."""
        return sum(one.twist.twist.linear.x > 0.5 for one in self._truth[self._from :])


def told(diagnostics: list[Any]) -> dict[str, str]:
    """The last diagnostics of the driving node."""
    return {one.key: one.value for one in diagnostics[-1].status[0].values} if diagnostics else {}


@pytest.mark.parametrize("rate", [5, 10])
def test_a_slow_lidar_drives_the_car_whatever_its_scans_look_like(lab: Any, tmp_path: Path, rate: int) -> None:
    car = tmp_path / "slow.yaml"
    period = 1.0 / rate
    car.write_text(f"lidar: {{rate: {rate}, sweep_time: {0.9 * period}, beams_vary: 40}}\n")
    lab.start_sim("arena", "--car", str(car))
    lab.start_drive(*CALM)
    truth = lab.probe.hear(Odometry, "/ground_truth/odom")
    scans = lab.probe.hear(LaserScan, "/scan")
    diagnostics = lab.probe.hear(DiagnosticArray, "/diagnostics", 10)
    for fault in FAULTS.values():
        assert set(lab.probe.set("/firstlap_sim", **fault)) <= {""}
        lab.driven(lab.probe.moves, "it drives")
        rolls = Rolls(truth)
        lab.driven(lambda rolls=rolls: rolls.scans() > 5 * rate, "it drives for seconds")
    assert len({len(one.ranges) for one in scans}) > 10, "they did differ"
    timeout = float(lab.until(lambda: told(diagnostics).get("scan timeout [s]"), "its timeout"))
    assert timeout == pytest.approx(2.5 * period, rel=0.02)
    assert "contact" not in lab.sim.output
    output = lab.drive.output
    assert "beams" not in output
    assert "future" not in output


@pytest.mark.parametrize(
    "lidar",
    [
        "yaw: 3.14159265, fov: 6.2831853, center_angle: 3.14159265, clockwise: true",
        "upside_down: true, yaw: 1.5707963, fov: 6.2",
    ],
)
def test_the_node_takes_the_mounting_of_a_simulated_laser_from_its_transform(
    lab: Any, tmp_path: Path, lidar: str
) -> None:
    car = tmp_path / "turned.yaml"
    car.write_text(f"lidar: {{{lidar}}}\n")
    lab.start_sim("arena", "--car", str(car))
    lab.start_drive(*CALM)
    lab.driven(lambda: "lap 1 in" in lab.sim.output, "a lap", seconds=150.0)
    assert "contact" not in lab.sim.output
