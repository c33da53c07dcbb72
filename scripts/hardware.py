"""Write docs/hardware.md from what `firstlap survey --lidar ... --json` printed.

Usage: scripts/hardware.py LIDAR.json... --seams SEAM.json... >docs/hardware.md

The commands stand in the page.
"""

import json
import pathlib
import sys
from typing import Any

from firstlap.car_file import Car, list_lidars, load_car, with_lidar

HEAD = """# Hardware

What firstlap is known to work with, and how that was checked. Nothing here was driven by us on a real car: what real
LiDARs and their drivers do was taken from data sheets and from recordings of other teams
([recordings.md](recordings.md)).

## LiDARs

Any planar LiDAR whose driver publishes `sensor_msgs/LaserScan` and that looks ahead. What does not matter:

- where the first beam points (`angle_min` of -π, 0 or anything else), and which way the LiDAR turns: the scan is
  brought into one order, with its seam behind the car, where it enters;
- how it is mounted: turned by any angle, upside down (a roll or pitch of 180°), ahead of the rear axle or beside the
  middle of the car; TF tells, or `--laser`, or the parameters `laser_yaw`, `car.laser_x` and `car.laser_y`;
- how many beams a scan has, and whether the number changes from scan to scan; more than 2,048 are thinned evenly;
- how "no return" is reported: NaN, infinite, 0, at or beyond a limit, or clipped at `range_max` with noise on it;
- the rate, down to 5 Hz: the driving node stops after 2.5 measured scan periods of silence, at most 0.5 s.

What is refused, with the reason: angles in degrees, ranges in millimeters or centimeters, a negative `time_increment`,
limits that are not numbers, a scan of more than a full turn, a laser that does not look ahead. A `time_increment` that
makes the sweep longer than the scan period is said and not used. One function judges a scan for everybody
(`cpp/firstlap/scan_check.hpp`); `firstlap preflight` shows what it says.

`--lidar NAME` puts one of these on the simulated car (`race`, `survey`, `compare`, `robustness`, `perception`,
`explain`, `map`, `sim`); `--lidar FILE` takes the section `lidar` of a YAML file, with every field of
[parameters.md](parameters.md). They are in `lidars/`, after the data sheets. `sure` on six of our tracks, {conditions}:

```sh
for lidar in {names}; do
  firstlap survey {tracks} --setup sure --laps {laps} --seeds {seeds} --both --lidar $lidar --json >$lidar.json
done
```

"""

LIDAR_NOTE = """
`lap` is the median lap over that with `utm30lx`. With a LiDAR of 5 Hz and 3.5 m the car is slower: it may only drive as
fast as it can stop within what it sees.

### Seam and direction

A full turn of 800 beams at 10 Hz, begun behind the car, ahead of it, and to its side, and turned either way; the motion
during the sweep of 0.1 s is undone by every driver. Median laps [s] of {tracks}, {conditions}:

```sh
firstlap survey {tracks} --setup SETUP --laps {laps} --seeds {seeds} --lidar rplidar_a2 \\
  --option lidar.center_angle=ANGLE --option lidar.clockwise=0|1 --json
```

"""

REST = """
## Odometry

`nav_msgs/Odometry` whose twist is in the car's frame: forward speed [m/s] and yaw rate [rad/s]; optionally an IMU and
the measured steering angle. A speed that is wrong by up to 15 %, of either sign, on the measurement alone or on command
and measurement alike, is found out by the walls that go by ([robustness.md](robustness.md)). Odometry that contradicts
its own poses, the scans or the commands (a twist in the frame of the map, a wrong sign, km/h, degrees per second, 0
while the car moves) is refused before the start, and stops the car while it drives ([on-the-car.md](on-the-car.md)).

## Cars

| car | what | checked on |
|---|---|---|
| `default` | 1/10, wheelbase 0.33 m, nonlinear tires, friction 0.75 | simulator; [results.md](results.md) |
| `nuc2` | ForzaETH's car, as identified by its team | simulator |
| `gym` | the car of f1tenth_gym | simulator; beside drivers of others in [peers.md](peers.md) |

Commands go out as `ackermann_msgs/AckermannDriveStamped`, which the muxes of f1tenth_system and race_stack take: their
sources were read, neither was driven.

## Software

Every commit is built and tested on Debian 12, x86-64, with g++ 12, Python 3.11 and ROS 2 Kilted from wheels. ROS 2
Humble and Jazzy from apt, aarch64 and a Jetson were not tried.
"""


def beams_of(car: Car) -> list[str]:
    """What a table says of a LiDAR."""
    lidar = car.core.values()["lidar"]
    beams = f"{lidar['beams']:g}"
    if lidar["beams_vary"]:
        beams = f"{lidar['beams'] - lidar['beams_vary']:g} to {beams}"
    turn = 360.0 if lidar["fov"] > 6.2 else lidar["fov"] * 57.29578
    near, far = lidar["range_min"], lidar["range_max"]
    return [beams, f"{turn:.0f}°", f"{lidar['rate']:g}", f"{near:g} to {far:g}", f"{1e3 * lidar['noise_sigma']:g}"]


def conditions(survey: dict[str, Any]) -> str:
    """How the races were."""
    ways = ", both ways" if survey["both"] else ""
    return f"{survey['laps']} laps, {survey['seeds']} seed{'s' if survey['seeds'] > 1 else ''}{ways}"


def lidar_rows(surveys: dict[str, dict[str, Any]]) -> list[str]:
    """The table of LiDARs."""
    lines = [
        "| LiDAR | beams | turn | Hz | range m | noise mm | finished | lap | clearance m |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    first = {row["track"]: row["median"] for row in surveys["utm30lx"]["tracks"]}
    for name in list_lidars():
        survey = surveys[name]
        ratios = sorted(row["median"] / first[row["track"]] for row in survey["tracks"] if row["median"])
        middle = len(ratios) // 2
        lap = 0.5 * (ratios[middle] + ratios[-middle - 1])
        clear = min(row["min_clearance"] for row in survey["tracks"])
        cells = [f"`{name}`", *beams_of(with_lidar(load_car("default"), name))]
        cells += [f"{survey['finished']} of {survey['runs']}", f"{lap:.3f}", f"{clear:.2f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def seam_rows(surveys: list[dict[str, Any]]) -> list[str]:
    """The table of seams and directions."""
    lines = ["| setup | begins | turns | finished | " + " | ".join(t["track"] for t in surveys[0]["tracks"]) + " |"]
    lines.append("|---|---|---|---|" + "---|" * len(surveys[0]["tracks"]))
    for survey in surveys:
        center = float(survey["options"].get("lidar.center_angle", 0.0))
        begins = "ahead" if center > 3.0 else "behind" if center == 0.0 else f"at {57.29578 * (center - 3.14159):.0f}°"
        turns = "right" if survey["options"].get("lidar.clockwise") else "left"
        laps = " | ".join(f"{row['median']:.2f}" if row["median"] else "-" for row in survey["tracks"])
        done = f"{survey['finished']} of {survey['runs']}"
        lines.append(f"| `{survey['setup']}` | {begins} | {turns} | {done} | {laps} |")
    return lines


def main(arguments: list[str]) -> None:
    """Prints the page."""
    at = arguments.index("--seams")
    read = [json.loads(pathlib.Path(name).read_text()) for name in (*arguments[:at], *arguments[at + 1 :])]
    lidars = {one["car"].rpartition(" ")[2]: one for one in read[:at]}
    seams = sorted(read[at:], key=lambda one: ("sure", "gap", "disparity", "pid").index(one["setup"]))
    one = next(iter(lidars.values()))
    tracks = " ".join(row["track"] for row in one["tracks"])
    names = " ".join(list_lidars())
    print(
        HEAD.format(names=names, tracks=tracks, laps=one["laps"], seeds=one["seeds"], conditions=conditions(one)),
        end="",
    )
    print("\n".join(lidar_rows(lidars)))
    short = " ".join(row["track"] for row in seams[0]["tracks"])
    print(
        LIDAR_NOTE.format(
            tracks=short, laps=seams[0]["laps"], seeds=seams[0]["seeds"], conditions=conditions(seams[0])
        ),
        end="",
    )
    print("\n".join(seam_rows(seams)))
    print(REST, end="")


if __name__ == "__main__":
    main(sys.argv[1:])
