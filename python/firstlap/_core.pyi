"""The C++ core of firstlap."""

from collections.abc import Iterator
from typing import Annotated, overload

import numpy
from numpy.typing import NDArray


class LaserScan:
    """
    One sweep of a planar LiDAR, as sensor_msgs/LaserScan. The seam between its first and last beam may lie anywhere, and it may turn either way. A range that is not finite, or not between range_min and range_max, is no return (REP 117).
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
        """All but the ranges, in the order of the table."""

    def returns(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]:
        """
        (beams,) which beams are returns; the others saw nothing, however that is spelled.
        """

    @staticmethod
    def columns() -> list:
        """The table of the header: a list of dicts with name, unit and doc."""

    @property
    def angle_min(self) -> float:
        """[rad] of the first beam, in the frame of a laser that looks ahead"""

    @property
    def angle_increment(self) -> float:
        """[rad] between beams, > 0 counter-clockwise"""

    @property
    def time_increment(self) -> float:
        """[s] between beams; 0 when all beams belong to one moment"""

    @property
    def range_min(self) -> float:
        """[m] nearer is no return"""

    @property
    def range_max(self) -> float:
        """[m] farther is no return"""

class VehicleState:
    """What the car measures about itself at the end of the sweep."""

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

def judge_scan(scan: LaserScan, period: float, angle_max: float) -> tuple:
    """
    Fault by name ('none'), reason ('' where the scan may be used) and remarks. period: [s] between scans, 0 not known; angle_max: [rad] as its message states it, NaN not known.
    """

def usable_sweep_time(time_increment: float, beams: int, period: float) -> float:
    """
    [s] from the first beam to the last; 0 where time_increment [s] is negative, not finite, or makes it longer than period [s] allows (0: not known).
    """

class ScanPeriod:
    """
    How often scans come, learned so slowly that a lost one does not matter.
    """

    def __init__(self) -> None: ...

    def learn(self, dt: float) -> None:
        """dt: [s] since the scan before."""

    @property
    def seconds(self) -> float:
        """[s] between scans; 0: not known."""

STATUSES: tuple = ...

class Params:
    """Every parameter of the method, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: Params) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class Driver:
    """Scan and state in, command out."""

    def reset(self) -> None:
        """Forgets everything."""

    def step(self, scan: LaserScan, state: VehicleState, dt: float) -> tuple:
        """
        Speed [m/s], wheel angle [rad] and status. dt: [s] since the scan before. Releases the GIL.
        """

class Racer(Driver):
    """The method: one scan in, one command out."""

    def __init__(self, params: Params) -> None:
        """Raises ValueError with field, value and range."""

    def set_params(self, params: Params) -> None:
        """
        Changes the parameters while driving. Raises ValueError as the constructor, and then keeps the old ones.
        """

    def trace(self) -> dict:
        """What the last step saw and thought, as numpy arrays in base_link."""

class FollowTheGapParams:
    """Every parameter of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: FollowTheGapParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class FollowTheGap(Driver):
    """Steers into the best gap."""

    def __init__(self, params: FollowTheGapParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """What the last step saw and thought; angles in the laser's frame."""

class DisparityExtenderParams:
    """Every parameter of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: DisparityExtenderParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class DisparityExtender(Driver):
    """Steers to where the most way is free."""

    def __init__(self, params: DisparityExtenderParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """What the last step saw and thought; angles in the laser's frame."""

class CenterPidParams:
    """Every parameter of the driver, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: CenterPidParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class CenterPid(Driver):
    """Steers to the middle between the walls."""

    def __init__(self, params: CenterPidParams) -> None:
        """Raises ValueError with field, value and range."""

    def trace(self) -> dict:
        """What the last step saw and thought; angles in the laser's frame."""

class CallbackDriver(Driver):
    """A driver that is written in Python."""

    def __init__(self, driver: object) -> None:
        """
        `driver` has reset() and step(scan: LaserScan, state: VehicleState, dt) -> (speed, steering_angle, status). What it raises ends the race.
        """

    def raise_error(self) -> None:
        """
        Raises what the Python object raised, once; until its reset the car is told to stop.
        """

class Track:
    """Walls and a closed centerline, as the simulator takes them."""

    def __init__(self, segments: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], visible: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)], solid: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)], centerline: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

class Car:
    """Every parameter of a simulated car, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: Car) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

    @staticmethod
    def preset(name: str) -> Car:
        """The car 'default', 'nuc2' or 'gym'. Raises KeyError."""

class Lidar:
    """The car's lidar on a track, without noise."""

    def __init__(self, track: Track, car: Car) -> None: ...

    def scan(self, x: float, y: float, yaw: float) -> Annotated[NDArray[numpy.float32], dict(shape=(None,))]:
        """Exact ranges [m] (beams,) from the laser's pose in the map frame."""

class Lap:
    """A complete lap."""

    def __init__(self, time: float = 0.0, distance: float = 0.0, mean_speed: float = 0.0, max_speed: float = 0.0, min_clearance: float = 0.0, rms_offset: float = 0.0, standing: bool = False) -> None: ...

    @property
    def time(self) -> float:
        """[s] from line to line"""

    @property
    def distance(self) -> float:
        """[m] driven by base_link"""

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
        """[m] of the place on the wall, map frame"""

    @property
    def y(self) -> float:
        """[m] of the place on the wall, map frame"""

    @property
    def s(self) -> float:
        """[m] of base_link along the centerline"""

    @property
    def obstacle(self) -> bool:
        """it was the sudden obstacle, not a wall"""

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
    The sudden obstacle, once it has appeared: its middle in the map frame.
    """

    def __init__(self, time: float = 0.0, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, speed: float = 0.0, yaw_rate: float = 0.0, clearance: float = 0.0) -> None: ...

    @property
    def time(self) -> float:
        """[s] when it appeared"""

    @property
    def x(self) -> float:
        """[m] to the front, or east in a map"""

    @property
    def y(self) -> float:
        """[m] to the left, or north in a map"""

    @property
    def yaw(self) -> float:
        """[rad] turned left"""

    @property
    def speed(self) -> float:
        """[m/s] of the car at that time"""

    @property
    def yaw_rate(self) -> float:
        """[rad/s] of the car at that time"""

    @property
    def clearance(self) -> float:
        """[m] smallest between car and obstacle since"""

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
    """How a race is run. The seed is an attribute of its own."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: RaceOptions) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

    @property
    def seed(self) -> int:
        """64 bits; the same seed gives the same race, bit for bit."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

class Race:
    """One car, one track, one driver, some laps; stepped scan by scan."""

    def __init__(self, track: Track, car: Car, driver: Driver, options: RaceOptions) -> None:
        """
        Resets the driver and stands the car on the line. Raises ValueError where that cannot be.
        """

    def advance(self, scans: int = 1) -> bool:
        """
        Drives for so many scan periods, without the GIL. False when the race is over. Raises what a driver in Python raised.
        """

    def result(self) -> dict:
        """What it has left behind so far; see docs/results-format.md."""

    def laps_done(self) -> int:
        """Complete laps."""

    def scan(self) -> LaserScan:
        """The scan that the driver saw last."""

    def measured(self) -> VehicleState:
        """The state that the driver was given last."""

    def state(self) -> VehicleState:
        """The true state now."""

    @property
    def pose(self) -> tuple:
        """x, y, yaw of base_link now."""

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

class MapParams:
    """Every parameter of mapping, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: MapParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class CloudMaker:
    """Scans as evenly spaced clouds with normals, in base_link."""

    def __init__(self, params: MapParams, car: Car) -> None: ...

    def make(self, scan: LaserScan, state: VehicleState, period: float = 0.0) -> tuple:
        """
        cloud (N, 4) x, y, nx, ny and all points (P, 3) x, y, range. Raises ValueError for a bad header.
        """

class ReferenceCloud:
    """Wall points with normals, found by place."""

    def __init__(self, points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

    def __len__(self) -> int: ...

def match(cloud: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], reference: ReferenceCloud, guess: tuple, prior: tuple, params: MapParams) -> tuple:
    """
    Point-to-line matching: pose (x, y, yaw) of the cloud in the reference, share of fitting points, their rms [m], and information (3, 3) in the cloud's frame. prior: standard deviations along, across, yaw.
    """

class ScanMotion:
    """How the car moved between scans, from the scans alone."""

    def __init__(self, params: MapParams, car: Car) -> None: ...

    def add(self, scan: LaserScan, time: float) -> object:
        """
        begin and end [s], forward, left [m], turn [rad] since the scan that was kept before, share of points that fit, and share that tells how far the car went; None until there is something to tell. time: [s] of the last beam. Releases the GIL.
        """

    def forget(self) -> None:
        """As if no scan had come."""

class OccupancyGrid:
    """Beams counted in cells; row 0 is the lowest."""

    def __init__(self, x: float, y: float, columns: int, rows: int, params: MapParams) -> None: ...

    def add(self, pose: tuple, laser: tuple[float, float], points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None:
        """
        Draws points (N, 3) x, y, range of base_link seen from its pose; laser: x, y of the laser there.
        """

    def cells(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None))]:
        """(rows, columns) 0 free, 1 occupied, 2 unknown."""

class Estimate:
    """Pose of base_link in the map's frame at the end of the sweep."""

    def __init__(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, std: float = 0.0, std_yaw: float = 0.0, fit: float = 0.0, searching: bool = True, lost: bool = True, speed_scale: float = 1.0, command_scale: float = 1.0) -> None: ...

    @property
    def x(self) -> float:
        """[m] to the front, or east in a map"""

    @property
    def y(self) -> float:
        """[m] to the left, or north in a map"""

    @property
    def yaw(self) -> float:
        """[rad] turned left"""

    @property
    def std(self) -> float:
        """[m] of the particles around the pose"""

    @property
    def std_yaw(self) -> float:
        """[rad] of the particles around the pose"""

    @property
    def fit(self) -> float:
        """share of the scan that lies on the map"""

    @property
    def searching(self) -> bool:
        """something does not fit: the filter looks further around"""

    @property
    def lost(self) -> bool:
        """the pose must not be trusted: stop"""

    @property
    def speed_scale(self) -> float:
        """true speed per measured, by how far the car came on the map"""

    @property
    def command_scale(self) -> float:
        """true speed per commanded, never below 1"""

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
    """Distance to the nearest wall of a map."""

    def __init__(self, occupied: Annotated[NDArray[numpy.uint8], dict(shape=(None, None), order='C', device='cpu', writable=False)], resolution: float, origin: tuple) -> None:
        """
        occupied (rows, columns) uint8, row 0 the lowest; origin (x, y, yaw) of the lower left corner.
        """

    @staticmethod
    def of_points(points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], resolution: float) -> LikelihoodField:
        """A field round a cloud (N, 4). Raises ValueError for none."""

    def search(self, cloud: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], guess: tuple, radius: float, angle: float, step: float, turn: float) -> tuple:
        """
        Best pose on a raster round the guess, and its share of fitting points.
        """

class LocalizerParams:
    """Every parameter of localization, in sections."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: LocalizerParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class Localizer:
    """Where the car is on a map, from scans and odometry."""

    def __init__(self, field: LikelihoodField, car: Car, params: LocalizerParams, seed: int) -> None: ...

    def start(self, x: float, y: float, yaw: float) -> None:
        """base_link is about here, in the map's frame [m, rad]."""

    def displace(self, x: float, y: float, yaw: float) -> None:
        """Shifts all that it believes, in base_link: a kidnapped car."""

    def step(self, scan: LaserScan, state: VehicleState, dt: float) -> Estimate:
        """Where the car is at the end of the sweep. Releases the GIL."""

    def commanded(self, speed: float) -> None:
        """The speed command [m/s] that was given after the last step."""

    def predict(self, pose: tuple, state: VehicleState, time: float) -> tuple:
        """The pose so many seconds later."""

    @property
    def particles(self) -> int:
        """How many there are now."""

def bench(track: Track, car: Car, params: Params, scans: int = 4000) -> dict:
    """
    Microseconds of each step, each noise-free scan and each run of the reference over a recorded drive, and simulated seconds per second of a race.
    """

def replay(driver: Driver, ranges: Annotated[NDArray[numpy.float32], dict(shape=(None,), order='C', device='cpu', writable=False)], sizes: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)], headers: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], states: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], dts: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> dict:
    """
    Steps through N scans that stand end to end in `ranges`. headers (N, 5) and states (N, 3): rows of the tables of LaserScan and VehicleState. Returns columns, see firstlap.recordings.step_log.
    """

class LoggedDriver(Driver):
    """A driver that keeps what it was given and what it made of it."""

    def __init__(self, driver: Driver) -> None: ...

    def take(self) -> dict:
        """
        Columns of the steps since the last call, as of `replay`, and what it was given: ranges, one scan after the other, sizes (N,), headers (N, 5), measured (N, 3), dt (N,).
        """

def truth(race: Race, first: int) -> dict:
    """
    pose (N, 3) x, y, yaw and motion (N, 2) speed, yaw rate at each scan of a race from scan `first` on.
    """

class WorldOptions:
    """How many cars, and how they are treated."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: WorldOptions) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class World:
    """
    Cars of one kind on one track, commanded from outside; see cpp/firstlap/sim/world.hpp.
    """

    def __init__(self, track: Track, car: Car, options: WorldOptions, seed: int) -> None:
        """Raises ValueError where the cars cannot start."""

    def advance(self) -> None:
        """One scan period of all cars."""

    def command(self, car: int, speed: float, steering_angle: float, after: float = 0.0) -> None:
        """Speed [m/s] and wheel angle [rad], `after` seconds from now."""

    def reset(self, car: int) -> None:
        """Back to its start, at rest; its laps begin anew."""

    def place(self, car: int, x: float, y: float, yaw: float) -> None:
        """To a pose [m, rad] of base_link, at rest."""

    def kick(self, car: int, lateral_speed: float, yaw_rate: float) -> None:
        """A shove [m/s], [rad/s]."""

    def fits(self, car: int, x: float, y: float, yaw: float) -> bool:
        """Whether it could stand there, on no wall and on no other car."""

    def change(self, car: Car, mu_scale: float) -> None:
        """
        The cars are like this from here on; they go on from where they are. Raises ValueError for parameters that cannot be, and for other beams, another rate of the lidar or another vehicle.model; then nothing has changed.
        """

    def truth(self, car: int) -> dict:
        """Pose in the map frame and true motion, SI."""

    def measured(self, car: int) -> VehicleState:
        """The state at the last scan, as the car has it."""

    def scan(self, car: int) -> LaserScan:
        """
        The last scan, as the drivers take it: with the laser's mounting turned in.
        """

    def laps(self, car: int) -> list[Lap]:
        """Complete laps since the reset, as of a race."""

    def laps_done(self, car: int) -> int:
        """Complete laps since the reset."""

    def contacts(self, car: int) -> int:
        """Contacts since the reset."""

    def clearance(self, car: int) -> float:
        """Smallest distance to a wall [m] since the reset."""

    def lap_clearance(self, car: int) -> float:
        """Smallest distance to a wall [m] in the lap so far, inf at its start."""

    def own_angles(self, car: int = 0) -> tuple:
        """
        angle_min, angle_increment of the last scan in the laser's own frame, as its driver reports them.
        """

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def period(self) -> float:
        """[s] between scans."""

    def __len__(self) -> int: ...

class StateEstimateParams:
    """Every parameter of the state estimate."""

    @overload
    def __init__(self) -> None:
        """Every parameter at its default."""

    @overload
    def __init__(self, other: StateEstimateParams) -> None:
        """A copy."""

    @staticmethod
    def fields() -> list:
        """
        The field table: a list of dicts with section, name, unit, min, max, default, doc and type.
        """

    def get(self, section: str, name: str) -> object:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """
        Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range.
        """

    def values(self) -> dict:
        """All values, {section: {name: value}}."""

    def validate(self) -> None:
        """
        Raises ValueError with field, value and range where a value, or a pair of values, is not allowed.
        """

class StateEstimate:
    """Wheel speed, yaw rate and wheel angle fused."""

    def __init__(self, params: StateEstimateParams) -> None:
        """Raises ValueError with field, value and range."""

    def predict(self, steering_angle: float, dt: float) -> None:
        """Moves on by dt [s] under a commanded wheel angle [rad]."""

    def measure_speed(self, speed: float) -> None:
        """[m/s] of the wheels."""

    def measure_yaw_rate(self, yaw_rate: float) -> None:
        """[rad/s] of the gyro."""

    def measure_steering(self, steering_angle: float) -> None:
        """[rad]"""

    def state(self) -> VehicleState:
        """As estimated now."""

    @property
    def yaw_rate_bias(self) -> float:
        """[rad/s] of the gyro."""

    def reset(self) -> None:
        """Forgets everything."""

def result_tables() -> dict:
    """
    The tables of scans, states, results and traces, and under left, right, line and path of the rows of a log: {struct: [{name, unit, doc}]}.
    """
