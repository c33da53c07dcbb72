"""Names of the simulator node's topics and frames: firstlap's or those of f1tenth_gym_ros."""

from __future__ import annotations

from dataclasses import dataclass

from firstlap.common.errors import InputError

GYM_CARS = ("ego", "opp")
GYM_LASER_X = 0.275


@dataclass(frozen=True)
class CarNames:
    """The names of one car. others: (topic, index of the car whose odometry it carries)."""

    scan: str
    odom: str
    drive: str
    odom_frame: str
    base_frame: str
    laser_frame: str
    prefix: str
    others: tuple[tuple[str, int], ...] = ()


def our_names(cars: int, namespaces: str) -> list[CarNames]:
    """A single car has no namespace by default; several cars have one each. Raises InputError."""
    given = [name.strip("/ ") for name in namespaces.split(",") if name.strip("/ ")]
    if given and len(given) != cars:
        raise InputError(f"namespaces '{namespaces}': {len(given)} for {cars} cars")
    spaces = given or ([""] if cars == 1 else [f"car{i + 1}" for i in range(cars)])
    if len(set(spaces)) < len(spaces):
        raise InputError(f"namespaces '{namespaces}': each car needs its own")
    prefixes = [f"{space}/" if space else "" for space in spaces]
    return [
        CarNames(f"{p}scan", f"{p}odom", f"{p}drive", f"{p}odom", f"{p}base_link", f"{p}laser", p) for p in prefixes
    ]


def gym_names(cars: int) -> list[CarNames]:
    """Names for the one or two cars of f1tenth_gym_ros. Raises InputError."""
    if cars > len(GYM_CARS):
        raise InputError(f"--gym-names with {cars} cars: f1tenth_gym_ros has names for one or two")
    return [
        CarNames(
            scan=("scan", "opp_scan")[i],
            odom=f"{name}_racecar/odom",
            drive=("drive", "opp_drive")[i],
            odom_frame="map",
            base_frame=f"{name}_racecar/base_link",
            laser_frame=f"{name}_racecar/laser",
            prefix=f"{name}_racecar/",
            others=((f"{name}_racecar/{GYM_CARS[1 - i]}_odom", 1 - i),) if cars == len(GYM_CARS) else (),
        )
        for i, name in enumerate(GYM_CARS[:cars])
    ]
