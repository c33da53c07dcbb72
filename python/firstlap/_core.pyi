"""The C++ core of firstlap."""

from collections.abc import Iterator
from typing import Annotated, overload

import numpy
from numpy.typing import NDArray


class LaserScan:
    """
    One sweep of a planar LiDAR, as sensor_msgs/LaserScan. The seam between first and last beam may be anywhere, and the LiDAR may rotate either way. A range that is not finite, or not between range_min and range_max, is no return (REP 117).
    """

    def __init__(self, ranges: Annotated[NDArray[numpy.float32], dict(shape=(None,), order='C', device='cpu', writable=False)], angle_min: float = -2.3561944902, angle_increment: float = 0.00436332313, time_increment: float = 0.0, range_min: float = 0.06, range_max: float = 30.0) -> None:
        """
        ranges: (beams,) [m], float32 and contiguous; not copied. Raises TypeError for other arrays.
        """

    @property
    def ranges(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,), order='C', device='cpu', writable=False)]:
        """(beams,) [m]"""

    @property
    def header(self) -> tuple[float, float, float, float, float]:
        """All fields but the ranges, in the order of the table."""

    def returns(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]:
        """(beams,) bool: which beams have a return."""

    @staticmethod
    def columns() -> list:
        """The table of the header: a list of dicts with name, unit and doc."""

    @property
    def angle_min(self) -> float:
        """
        [rad] direction of the first beam, in the frame of a LiDAR that faces forward
        """

    @property
    def angle_increment(self) -> float:
        """[rad] between beams, > 0 counterclockwise"""

    @property
    def time_increment(self) -> float:
        """[s] between beams; 0: all beams are measured at the same time"""

    @property
    def range_min(self) -> float:
        """[m] shorter ranges are no return"""

    @property
    def range_max(self) -> float:
        """[m] longer ranges are no return"""

class VehicleState:
    """State measured by the car at the end of the sweep."""

    def __init__(self, speed: float = 0.0, yaw_rate: float = 0.0, steering_angle: float = 0.0) -> None: ...

    @property
    def speed(self) -> float:
        """[m/s] along base_link x"""

    @property
    def yaw_rate(self) -> float:
        """[rad/s] left positive"""

    @property
    def steering_angle(self) -> float:
        """[rad] of the front wheels, left positive"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float], /) -> None: ...

class SensorReading:
    """Measurements of the car's own sensors. NaN: not measured."""

    def __init__(self, wheel_speed: float = 0.0, yaw_rate: float = 0.0, steering_angle: float = 0.0, acceleration_x: float = 0.0, acceleration_y: float = 0.0) -> None: ...

    @property
    def wheel_speed(self) -> float:
        """[m/s] speed of the wheels' circumference"""

    @property
    def yaw_rate(self) -> float:
        """[rad/s] of the gyro, left positive"""

    @property
    def steering_angle(self) -> float:
        """[rad] of the servo, left positive"""

    @property
    def acceleration_x(self) -> float:
        """[m/s^2] of the accelerometer, forward"""

    @property
    def acceleration_y(self) -> float:
        """[m/s^2] of the accelerometer, to the left"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, float], /) -> None: ...

def judge_scan(scan: LaserScan, period: float, angle_max: float) -> tuple:
    """
    Returns the fault by name ('none'), the reason ('' if the scan is usable) and remarks. period: [s] between scans, 0 if unknown; angle_max: [rad] as in the message, NaN if unknown.
    """

def usable_sweep_time(time_increment: float, beams: int, period: float) -> float:
    """
    [s] from the first beam to the last; 0 if time_increment [s] is negative, not finite, or gives a longer sweep than period [s] allows (0: unknown).
    """

class ScanPeriod:
    """
    The scan period, low-pass filtered so that a lost scan has little effect.
    """

    def __init__(self) -> None: ...

    def learn(self, dt: float) -> None:
        """dt: [s] since the previous scan."""

    @property
    def seconds(self) -> float:
        """[s] between scans; 0: unknown."""

STATUSES: tuple = ...

class Params:
    """All parameters of the map-less method, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: Params) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class Driver:
    """Scan and state in, command out."""

    def reset(self) -> None:
        """Clears the memory of all earlier scans."""

    def step(self, scan: LaserScan, state: VehicleState, dt: float) -> tuple:
        """
        Returns speed [m/s], steering angle [rad] and status. dt: [s] since the previous scan. Releases the GIL.
        """

class Racer(Driver):
    """The map-less method: one scan in, one command out."""

    def __init__(self, params: Params) -> None:
        """Raises ValueError with field, value and range."""

    def set_params(self, params: Params) -> None:
        """
        Changes the parameters while driving. Raises ValueError as the constructor does; then the old ones stay.
        """

    def trace(self) -> dict:
        """
        Intermediate results of the last step, as numpy arrays in base_link; see docs/results-format.md.
        """

class FollowTheGapParams:
    """All parameters of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: FollowTheGapParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class FollowTheGap(Driver):
    """Follow the gap: steers into the best gap."""

    def __init__(self, params: FollowTheGapParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """
        Intermediate results of the last step; angles in the LiDAR's frame. See docs/results-format.md.
        """

class DisparityExtenderParams:
    """All parameters of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: DisparityExtenderParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class DisparityExtender(Driver):
    """Disparity extender: steers to the farthest free direction."""

    def __init__(self, params: DisparityExtenderParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """
        Intermediate results of the last step; angles in the LiDAR's frame. See docs/results-format.md.
        """

class CenterPidParams:
    """All parameters of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: CenterPidParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class CenterPid(Driver):
    """PID center following: steers to the center between the walls."""

    def __init__(self, params: CenterPidParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """
        Intermediate results of the last step; angles in the LiDAR's frame. See docs/results-format.md.
        """

class CallbackDriver(Driver):
    """A driver written in Python."""

    def __init__(self, driver: object) -> None:
        """
        `driver` has reset() and step(scan: LaserScan, state: VehicleState, dt) -> (speed, steering_angle, status). An exception ends the race.
        """

    def raise_error(self) -> None:
        """
        Raises the exception of the Python object, once. After an exception the car stops until the next reset.
        """

class Track:
    """Walls and a closed centerline for the simulator."""

    def __init__(self, segments: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], visible: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)], solid: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)], centerline: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

class Car:
    """All parameters of a simulated car, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: Car) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

    @staticmethod
    def preset(name: str) -> Car:
        """The car 'default', 'nuc2' or 'gym'. Raises KeyError."""

class Lidar:
    """The car's LiDAR on a track, without noise."""

    def __init__(self, track: Track, car: Car) -> None: ...

    def scan(self, x: float, y: float, yaw: float) -> Annotated[NDArray[numpy.float32], dict(shape=(None,))]:
        """
        Exact ranges [m] (beams,) from the LiDAR's pose in the map frame [m, rad].
        """

class Lap:
    """A completed lap."""

    def __init__(self, time: float = 0.0, distance: float = 0.0, mean_speed: float = 0.0, max_speed: float = 0.0, min_clearance: float = 0.0, rms_offset: float = 0.0, standing: bool = False) -> None: ...

    @property
    def time(self) -> float:
        """[s] line to line"""

    @property
    def distance(self) -> float:
        """[m] traveled by base_link"""

    @property
    def mean_speed(self) -> float:
        """[m/s] distance over time"""

    @property
    def max_speed(self) -> float:
        """[m/s] highest"""

    @property
    def min_clearance(self) -> float:
        """[m] from the car to the nearest solid wall"""

    @property
    def rms_offset(self) -> float:
        """[m] from the centerline, over time"""

    @property
    def standing(self) -> bool:
        """started from standstill"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, float, float, bool], /) -> None: ...

class Contact:
    """When and where the car touched a wall or the sudden obstacle."""

    def __init__(self, time: float = 0.0, x: float = 0.0, y: float = 0.0, s: float = 0.0, obstacle: bool = False) -> None: ...

    @property
    def time(self) -> float:
        """[s] since the start"""

    @property
    def x(self) -> float:
        """[m] of the contact point, map frame"""

    @property
    def y(self) -> float:
        """[m] of the contact point, map frame"""

    @property
    def s(self) -> float:
        """[m] of base_link along the centerline"""

    @property
    def obstacle(self) -> bool:
        """contact with the sudden obstacle, not with a wall"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, bool], /) -> None: ...

class ObstacleSeen:
    """
    The sudden obstacle, once it has appeared, with its center in the map frame.
    """

    def __init__(self, time: float = 0.0, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, speed: float = 0.0, yaw_rate: float = 0.0, clearance: float = 0.0) -> None: ...

    @property
    def time(self) -> float:
        """[s] when it appeared"""

    @property
    def x(self) -> float:
        """[m] forward, or east in a map"""

    @property
    def y(self) -> float:
        """[m] left, or north in a map"""

    @property
    def yaw(self) -> float:
        """[rad] counterclockwise"""

    @property
    def speed(self) -> float:
        """[m/s] of the car at that time"""

    @property
    def yaw_rate(self) -> float:
        """[rad/s] of the car at that time"""

    @property
    def clearance(self) -> float:
        """[m] smallest distance between car and obstacle since then"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, float, float, float], /) -> None: ...

class RaceOptions:
    """Options of a race. The seed is a separate attribute."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: RaceOptions) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

    @property
    def seed(self) -> int:
        """64 bits; the same seed gives the same race, bit for bit."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

class Race:
    """One car on one track with one driver, stepped scan by scan."""

    def __init__(self, track: Track, car: Car, driver: Driver, options: RaceOptions) -> None:
        """
        Resets the driver and places the car on the start line. Raises ValueError for an invalid track, option or start.
        """

    def advance(self, scans: int = 1) -> bool:
        """
        Drives for `scans` scan periods; releases the GIL. Returns False when the race is over. Raises the exception of a Python driver.
        """

    def result(self) -> dict:
        """The result so far; see docs/results-format.md."""

    def laps_done(self) -> int:
        """Number of completed laps."""

    def scan(self) -> LaserScan:
        """The last scan given to the driver."""

    def measured(self) -> VehicleState:
        """The last state given to the driver."""

    def reading(self) -> SensorReading:
        """The measurements of the car's sensors at the last scan."""

    def state(self) -> VehicleState:
        """The current true state."""

    @property
    def lateral_speed(self) -> float:
        """[m/s] of base_link, true, left positive."""

    @property
    def pose(self) -> tuple:
        """Current x, y, yaw of base_link in the map frame [m, rad]."""

    @property
    def time(self) -> float:
        """[s] since the start."""

    @property
    def s(self) -> float:
        """[m] along the centerline."""

    @property
    def lateral_offset(self) -> float:
        """[m] left of the centerline."""

    @property
    def track_length(self) -> float:
        """[m] of the centerline."""

class LapSearchOptions:
    """Resolution and safety distance of `search_lap`."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: LapSearchOptions) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

def search_lap(track: Track, car: Car, options: LapSearchOptions) -> dict:
    """
    Whether the car can drive laps of the track at all, without reverse; releases the GIL. Returns a dict, see LapSearchResult in docs/results-format.md. Raises ValueError for an invalid option or track.
    """

class MapParams:
    """All parameters of mapping, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: MapParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class CloudMaker:
    """Converts scans to evenly spaced clouds with normals, in base_link."""

    def __init__(self, params: MapParams, car: Car) -> None: ...

    def make(self, scan: LaserScan, state: VehicleState, period: float = 0.0) -> tuple:
        """
        Returns the cloud (N, 4) x, y, nx, ny and all points (P, 3) x, y, range, in base_link [m]. period: [s] between scans, 0 if unknown. Raises ValueError for an invalid scan.
        """

class ReferenceCloud:
    """
    Wall points with normals, (N, 4) x, y, nx, ny, in a grid for nearest-neighbor search.
    """

    def __init__(self, points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

    def __len__(self) -> int: ...

def match(cloud: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], reference: ReferenceCloud, guess: tuple, prior: tuple, params: MapParams) -> tuple:
    """
    Point-to-line matching. Returns the pose (x, y, yaw) of the cloud in the reference, the share of points that match, their RMS distance [m], and the information matrix (3, 3) in the cloud's frame. prior: standard deviations along [m], across [m], yaw [rad] of the guess.
    """

class ScanMotion:
    """Motion of the car between scans, from the scans alone."""

    def __init__(self, params: MapParams, car: Car) -> None: ...

    def add(self, scan: LaserScan, time: float) -> object:
        """
        Returns begin and end [s], forward and left [m], turn [rad] since the reference scan, the share of points that match, and the share that constrains the forward motion; None if there is no motion to report yet. time: [s] of the last beam. Releases the GIL.
        """

    def forget(self) -> None:
        """Clears all earlier scans."""

class OccupancyGrid:
    """Counts the beams that pass or end in each cell; row 0 is the lowest."""

    def __init__(self, x: float, y: float, columns: int, rows: int, params: MapParams) -> None: ...

    def add(self, pose: tuple, laser: tuple[float, float], points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None:
        """
        Adds points (N, 3) x, y, range in base_link, with base_link at `pose` (x, y, yaw) in the map. laser: (x, y) of the LiDAR in base_link.
        """

    def cells(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None))]:
        """(rows, columns) uint8: 0 free, 1 occupied, 2 unknown."""

class Estimate:
    """Pose of base_link in the map's frame at the end of the sweep."""

    def __init__(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, std: float = 0.0, std_yaw: float = 0.0, fit: float = 0.0, searching: bool = True, lost: bool = True, speed_scale: float = 1.0, command_scale: float = 1.0) -> None: ...

    @property
    def x(self) -> float:
        """[m] forward, or east in a map"""

    @property
    def y(self) -> float:
        """[m] left, or north in a map"""

    @property
    def yaw(self) -> float:
        """[rad] counterclockwise"""

    @property
    def std(self) -> float:
        """[m] standard deviation of the particles around the pose"""

    @property
    def std_yaw(self) -> float:
        """[rad] standard deviation of the particles around the pose"""

    @property
    def fit(self) -> float:
        """share of the scan that lies on the map"""

    @property
    def searching(self) -> bool:
        """something does not fit: the filter searches farther around"""

    @property
    def lost(self) -> bool:
        """the pose must not be trusted: stop"""

    @property
    def speed_scale(self) -> float:
        """true speed per measured speed, from the motion on the map"""

    @property
    def command_scale(self) -> float:
        """true speed per commanded speed, never below 1"""

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, float, float, bool, bool, float, float], /) -> None: ...

class LikelihoodField:
    """Distance to the nearest wall of an occupancy map."""

    def __init__(self, occupied: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu', writable=False)], resolution: float, origin: tuple) -> None:
        """
        occupied: (rows, columns) uint8, row 0 the lowest, nonzero for walls; resolution: [m] cell size; origin: (x, y, yaw) [m, rad] of the lower left corner in the map.
        """

    @staticmethod
    def of_points(points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], resolution: float) -> LikelihoodField:
        """A field around a cloud (N, 4). Raises ValueError for an empty cloud."""

    def search(self, cloud: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], guess: tuple, radius: float, angle: float, step: float, turn: float) -> tuple:
        """
        Exhaustive search around the guess (x, y, yaw). Returns the best pose, and the share of points that match. radius, step: [m]; angle, turn: [rad].
        """

class LocalizerParams:
    """All parameters of localization, in sections."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: LocalizerParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class Localizer:
    """Localization on a map from scans and odometry."""

    def __init__(self, field: LikelihoodField, car: Car, params: LocalizerParams, seed: int) -> None: ...

    def start(self, x: float, y: float, yaw: float) -> None:
        """
        Sets the start pose: base_link is near (x, y, yaw) in the map's frame [m, rad].
        """

    def displace(self, x: float, y: float, yaw: float) -> None:
        """
        Shifts all estimates by (x, y, yaw) in base_link [m, rad], as if the car had been moved by hand.
        """

    def step(self, scan: LaserScan, state: VehicleState, dt: float) -> Estimate:
        """
        Returns the estimate at the end of the sweep. dt: [s] since the previous scan. Releases the GIL.
        """

    def commanded(self, speed: float) -> None:
        """The speed command [m/s] given after the last step."""

    def predict(self, pose: tuple, state: VehicleState, time: float) -> tuple:
        """
        The pose (x, y, yaw) `time` seconds later, at the measured speed and yaw rate.
        """

    @property
    def particles(self) -> int:
        """Current number of particles."""

def bench(track: Track, car: Car, params: Params, scans: int = 4000) -> dict:
    """
    Times a recorded drive: microseconds of each step, of each noise-free scan and of each run of the reference, and the real-time factor of a race.
    """

def replay(driver: Driver, ranges: Annotated[NDArray[numpy.float32], dict(shape=(None,), order='C', device='cpu', writable=False)], sizes: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)], headers: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], states: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], dts: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> dict:
    """
    Steps through N scans whose ranges are concatenated in `ranges`; sizes (N,). headers (N, 5) and states (N, 3) are rows of the tables of LaserScan and VehicleState; dts (N,) [s]. Returns columns, see firstlap.recordings.step_log.
    """

class LoggedDriver(Driver):
    """A driver that logs its inputs and results."""

    def __init__(self, driver: Driver) -> None: ...

    def take(self) -> dict:
        """
        Columns of the steps since the last call, as from `replay`, and the inputs: ranges (concatenated), sizes (N,), headers (N, 5), measured (N, 3), dt (N,).
        """

def truth(race: Race, first: int) -> dict:
    """
    pose (N, 3) x, y, yaw in the map and motion (N, 2) speed, yaw rate at each scan of a race, from scan `first` on.
    """

class WorldOptions:
    """Number of cars, and how they are treated."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: WorldOptions) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class World:
    """
    Several identical cars on one track, commanded from outside; see cpp/firstlap/sim/world.hpp.
    """

    def __init__(self, track: Track, car: Car, options: WorldOptions, seed: int) -> None:
        """Raises ValueError for invalid parameters or starts."""

    def advance(self) -> None:
        """Advances all cars by one scan period. Releases the GIL."""

    def command(self, car: int, speed: float, steering_angle: float, after: float = 0.0) -> None:
        """Commands speed [m/s] and steering angle [rad], `after` [s] from now."""

    def reset(self, car: int) -> None:
        """Places the car at its start, at rest; its laps start again."""

    def place(self, car: int, x: float, y: float, yaw: float) -> None:
        """Places base_link at a pose [m, rad] in the map frame, at rest."""

    def kick(self, car: int, lateral_speed: float, yaw_rate: float) -> None:
        """A disturbance: adds to lateral speed [m/s] and yaw rate [rad/s]."""

    def fits(self, car: int, x: float, y: float, yaw: float) -> bool:
        """
        Whether the car can be placed there, without contact with a wall or another car.
        """

    def change(self, car: Car, mu_scale: float) -> None:
        """
        Changes the parameters of all cars from now on; motion and laps continue. Raises ValueError for invalid parameters, or a change of lidar.beams, lidar.rate or vehicle.model; then nothing changes.
        """

    def truth(self, car: int) -> dict:
        """Pose in the map frame and true motion, in SI units."""

    def measured(self, car: int) -> VehicleState:
        """The state given to the driver at the last scan."""

    def reading(self, car: int) -> SensorReading:
        """The measurements of the car's sensors at the last scan."""

    def scan(self, car: int) -> LaserScan:
        """
        The last scan, as drivers take it: its angles include the LiDAR's mounting.
        """

    def laps(self, car: int) -> list[Lap]:
        """Completed laps since the last reset, as in a race."""

    def laps_done(self, car: int) -> int:
        """Number of completed laps since the last reset."""

    def contacts(self, car: int) -> int:
        """Number of contacts since the last reset."""

    def clearance(self, car: int) -> float:
        """Smallest distance to a wall [m] since the last reset."""

    def lap_clearance(self, car: int) -> float:
        """Smallest distance to a wall [m] in the current lap, inf at its start."""

    def own_angles(self, car: int = 0) -> tuple:
        """
        angle_min, angle_increment [rad] of the last scan in the LiDAR's own frame, as its ROS driver reports them.
        """

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def period(self) -> float:
        """[s] between scans."""

    def __len__(self) -> int: ...

class StateEstimateParams:
    """All parameters of the state estimation."""

    @overload
    def __init__(self) -> None:
        """All parameters at their defaults."""

    @overload
    def __init__(self, other: StateEstimateParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError for an unknown name."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range if a value, or a pair of values, is not allowed.
        """

class MotionEstimate:
    """The estimated motion of the car."""

    def __init__(self, speed: float = 0.0, yaw_rate: float = 0.0, steering_angle: float = 0.0, lateral_speed: float = 0.0, yaw_rate_bias: float = 0.0, acceleration_x_bias: float = 0.0, acceleration_y_bias: float = 0.0, wheel_slip: float = 0.0, wheels_rejected: bool = False) -> None: ...

    @property
    def speed(self) -> float:
        """[m/s] along base_link x"""

    @property
    def yaw_rate(self) -> float:
        """[rad/s] left positive"""

    @property
    def steering_angle(self) -> float:
        """[rad] of the front wheels, left positive"""

    @property
    def lateral_speed(self) -> float:
        """[m/s] of base_link, left positive"""

    @property
    def yaw_rate_bias(self) -> float:
        """[rad/s] of the gyro"""

    @property
    def acceleration_x_bias(self) -> float:
        """[m/s^2] of the accelerometer, forward"""

    @property
    def acceleration_y_bias(self) -> float:
        """[m/s^2] of the accelerometer, to the left"""

    @property
    def wheel_slip(self) -> float:
        """[s^2/m] slip of the wheels per acceleration"""

    @property
    def wheels_rejected(self) -> bool:
        """
        the wheel speed contradicts the accelerometer, because the wheels lock or spin
        """

    @staticmethod
    def columns() -> list:
        """The table: a list of dicts with name, unit and doc."""

    def to_dict(self) -> dict:
        """{name: value}, in the order of the table."""

    def __iter__(self) -> Iterator[float]: ...

    def __eq__(self, arg: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, arg: tuple[float, float, float, float, float, float, float, float, bool], /) -> None: ...

class StateEstimate:
    """
    Extended Kalman filter of wheel speed, gyro, accelerometer, steering angle and command.
    """

    def __init__(self, params: StateEstimateParams, car: Car) -> None:
        """Raises ValueError with field, value and range."""

    def update(self, reading: SensorReading, speed: float, steering_angle: float, dt: float) -> None:
        """
        Updates with a reading `dt` [s] after the last one. `speed` [m/s], `steering_angle` [rad]: the command in effect from now on, NaN if it is not known.
        """

    def set_params(self, params: StateEstimateParams, car: Car) -> None:
        """Keeps the estimate. Raises ValueError like the constructor."""

    def estimate(self) -> MotionEstimate:
        """The current estimate."""

    def reset(self) -> None:
        """Forgets everything."""

def estimate_all(car: Car, readings: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], commands: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], dts: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
    """
    (N, K) rows of the table of MotionEstimate. readings (N, 5), commands (N, 2): rows of the tables of SensorReading and DriveCommand, the command in effect before each reading; dts (N,) [s] before each.
    """

def result_tables() -> dict:
    """
    The tables of scans, states, results and traces, and of the rows left, right, line and path of a log: {struct: [{name, unit, doc}]}.
    """
