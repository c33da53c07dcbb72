"""Write docs/hardware.md from the output of `firstlap survey --lidar ... --json`.

Usage: scripts/hardware_page.py LIDAR.json... --seams SEAM.json... >docs/hardware.md

The page lists the commands.
"""

import json
import pathlib
import sys
from typing import Any

from firstlap.config.car_file import Car, list_lidars, load_car, with_lidar

HEAD = """# Hardware

Hardware that firstlap is known to work with, and how this was checked. We did not drive a real car: the behavior of
real LiDARs and their ROS drivers was taken from data sheets and from recordings of other teams
([recordings.md](recordings.md)).

## LiDARs

Any planar LiDAR that faces forward and whose ROS driver publishes `sensor_msgs/LaserScan` works. All of the following
are handled:

- any direction of the first beam (`angle_min` of -π, 0 or other) and either direction of rotation: every scan is
  normalized at the input, with its seam behind the car;
- any mounting: rotated by any angle, upside down (a roll or pitch of 180°), ahead of the rear axle or off the car's
  center line. It is read from TF, `--laser`, or the parameters `laser_yaw`, `car.laser_x` and `car.laser_y`;
- any number of beams, also one that changes from scan to scan; more than 2,048 are thinned evenly;
- any encoding of "no return": NaN, infinite, 0, at or beyond a limit, or clipped at `range_max` with noise on it;
- any rate from 5 Hz on: the driving node stops after 2.5 measured scan periods without a scan, at most 0.5 s.

Refused, with the reason: angles in degrees, ranges in millimeters or centimeters, a negative `time_increment`, limits
that are not numbers, a scan of more than a full turn, a LiDAR that does not face forward. A `time_increment` that
makes the sweep longer than the scan period is reported and ignored. One function checks scans for all users
(`cpp/firstlap/perception/scan_check.hpp`); `firstlap preflight` shows its result.

`--lidar NAME` puts one of the LiDARs below on the simulated car (`race`, `survey`, `compare`, `robustness`,
`perception`, `explain`, `map`, `sim`); `--lidar FILE` reads the section `lidar` of a YAML file with any field of
[parameters.md](parameters.md). The files in `lidars/` follow the data sheets. `sure` on six of our tracks,
{conditions}:

```sh
for lidar in {names}; do
  firstlap survey {tracks} --setup sure --laps {laps} --seeds {seeds} --both --lidar $lidar --json >$lidar.json
done
```

"""

LIDAR_NOTE = """
`lap` is the median lap relative to `utm30lx`. With a LiDAR of 5 Hz and 3.5 m the car is slower, because it drives only
as fast as it can stop within its view.

### Seam and direction of rotation

A full turn of 800 beams at 10 Hz that begins behind, ahead of, or beside the car, in either direction of rotation.
Every driver undoes the motion during the sweep of 0.1 s. Median laps [s] of {tracks}, {conditions}:

```sh
firstlap survey {tracks} --setup SETUP --laps {laps} --seeds {seeds} --lidar rplidar_a2 \\
  --option lidar.center_angle=ANGLE --option lidar.clockwise=0|1 --json
```

"""

REST = """
## Odometry

`nav_msgs/Odometry` with the twist in the car's frame: forward speed [m/s] and yaw rate [rad/s]; optionally an IMU and
the measured steering angle. Speed errors of up to 15 % of either sign, of the measurement alone or of command and
measurement alike, are estimated from the walls ([robustness.md](robustness.md)). Odometry that contradicts its own
poses, the scans or the commands (a twist in the map frame, a wrong sign, km/h, degrees per second, 0 while the car
moves) is refused before the start, and stops the car while driving ([on-the-car.md](on-the-car.md#odometry-checks)).

## Cars

| car | description | checked in |
|---|---|---|
| `default` | 1/10, wheelbase 0.33 m, nonlinear tires, friction 0.75 | simulator; [results.md](results.md) |
| `nuc2` | ForzaETH's car, as identified by its team | simulator |
| `gym` | the car of f1tenth_gym | simulator; compared with drivers of others in [peers.md](peers.md) |

Commands are published as `ackermann_msgs/AckermannDriveStamped`, which the muxes of f1tenth_system and race_stack
accept; this was checked in their source code only.

## Software

Every commit is built and tested on Debian 12, x86-64, with g++ 12, Python 3.11 and ROS 2 Kilted from wheels. ROS 2
Humble and Jazzy from apt, aarch64 and a Jetson have not been tried.
"""


def beams_of(car: Car) -> list[str]:
    """The data of a LiDAR as table cells."""
    lidar = car.core.values()["lidar"]
    beams = f"{lidar['beams']:g}"
    if lidar["beams_vary"]:
        beams = f"{lidar['beams'] - lidar['beams_vary']:g} to {beams}"
    turn = 360.0 if lidar["fov"] > 6.2 else lidar["fov"] * 57.29578
    near, far = lidar["range_min"], lidar["range_max"]
    return [beams, f"{turn:.0f}°", f"{lidar['rate']:g}", f"{near:g} to {far:g}", f"{1e3 * lidar['noise_sigma']:g}"]


def conditions(survey: dict[str, Any]) -> str:
    """Size of a survey."""
    directions = ", both directions" if survey["both"] else ""
    seeds = f"{survey['seeds']} seed{'s' if survey['seeds'] > 1 else ''}"
    return f"{survey['laps']} laps, {seeds}{directions}"


def lidar_rows(surveys: dict[str, dict[str, Any]]) -> list[str]:
    """The table of LiDARs."""
    lines = [
        "| LiDAR | beams | field of view | Hz | range m | noise mm | finished | lap | clearance m |",
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
    """The table of first beams and directions of rotation."""
    lines = [
        "| setup | first beam | rotation | finished | " + " | ".join(t["track"] for t in surveys[0]["tracks"]) + " |"
    ]
    lines.append("|---|---|---|---|" + "---|" * len(surveys[0]["tracks"]))
    for survey in surveys:
        center = float(survey["options"].get("lidar.center_angle", 0.0))
        begins = "ahead" if center > 3.0 else "behind" if center == 0.0 else f"at {57.29578 * (center - 3.14159):.0f}°"
        turns = "clockwise" if survey["options"].get("lidar.clockwise") else "counterclockwise"
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
