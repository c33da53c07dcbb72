"""A car, or a simulator's car, over ROS 2: its driving node's own trace, and without one what its sensors say."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car, car_section, load_car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import Field, Value
from firstlap.config.setup_file import Setup, choose_setup
from firstlap.perception.frames import mount_of
from firstlap.perception.scan import Mount, laser_of, ray_ends, set_laser
from firstlap.pitwall.frame import Frame, Scenery
from firstlap.pitwall.holding import Holding
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.places import Places, clearance, points_of
from firstlap.recordings.trace_tables import TABLE_NAMES
from firstlap.ros import require_ros
from firstlap.ros.car_link import CarLink
from firstlap.ros.conversions import judged
from firstlap.ros.trace_message import STATUS, TRACE, TraceHeader
from firstlap.ros.trace_reader import TraceReader

NODE = "firstlap_drive"
MAP_TOPIC = "/map"
TRUTH_TOPIC = "ground_truth/odom"
LOST = 0.5
"""[s] without a trace from which that is said, and the bare scan shown."""
LOOK = 0.1
"""[s] between two looks at whether everybody is still there."""
FIRST = 5.0
"""[s]"""
MAP_LASTS, MAP_LONGEST = 2.0, 16.0
"""[s] that `start`, and the first try, waits for what somebody publishes of the map; each further one twice as long."""


class RosSource(Holding):
    """A `Source` that `Drives`. arguments: for ROS, as `ros_arguments` makes them. node: of the driver.
    patience: [s] that `start` waits for that node to say what it drives with.

    `close` leaves the car as it is: it is not ours. One that was stopped here stays stopped.
    """

    def __init__(
        self, arguments: list[str] | None = None, node: str = NODE, domain: int | None = None, patience: float = FIRST
    ) -> None:
        self._link = CarLink(arguments or ["--ros-args"], node, domain)
        self.title = node
        self._patience = patience
        self.car: Car = load_car("default")
        self.scenery = Scenery()
        super().__init__(choose_setup(None, None))  # until a driving node has said its own
        self._known = threading.Event()
        self._changing = threading.Lock()
        self._places = Places()
        self._walls: tuple[Any, ...] = ()
        self._of_map: list[Any] = []
        self._map_asked, self._map_tries = -math.inf, 0
        self._born, self._was_there, self._stale, self._asked = "", False, True, -math.inf
        self._trace_at = self._scan_at = self._began = -math.inf
        self._bad_trace = ""
        self._steps = TraceReader()
        self._mount: Mount | None = None
        self._scan: dict[str, Any] = {}
        self._topics: dict[str, Any] = {}

    # Source.

    def start(self) -> None:
        """Joins, and waits a moment for the driving node. Raises InputError where ROS 2 is not there."""
        require_ros()
        self._began = time.monotonic()
        self._link.start(self._build, self._look, LOOK)
        self.title = f"{self._link.path} over ROS 2"
        self._known.wait(self._patience)
        until = time.monotonic() + min(self._patience, MAP_LASTS)
        while self._link.published(MAP_TOPIC) and not self.scenery.walls and time.monotonic() < until:
            time.sleep(0.5 * LOOK)

    def close(self) -> None:
        """Leaves."""
        self._link.close()

    def change(self, values: Mapping[str, Value]) -> None:
        """In the node: all are taken, or InputError with its reason."""
        with self._changing:
            fields = self._setup.fields
            asked = {fields.find(name, "setup"): value for name, value in values.items()}
            self._link.set(asked)
            self._taken(asked)

    def choose(self, setup: Setup) -> None:
        """All its parameters, in the node. Raises InputError where it is of another driver than the node's."""
        if setup.driver != self._setup.driver:
            raise InputError(
                f"{self._link.path} drives with {self._setup.driver}: restart it with "
                f"`firstlap drive --driver {setup.driver} --setup {setup.source or setup.name}`"
            )
        self.change({field.key: setup.get(field.key) for field in setup.fields.fields})
        self._setup = self._loaded = setup

    def _taken(self, values: Mapping[Field, Value]) -> None:
        """The node has them now."""
        new = {(field.section, field.name): value for field, value in values.items()}
        before = self._setup
        changed = replace(before, given={**before.given, **new}, changed={**before.changed, **new})
        self._setup = changed_from(changed, self._loaded)
        self._see_car()

    # Drives.

    def stop(self) -> None:
        """The emergency stop, held until `go`; and ~/stop."""
        try:
            self._link.stop()
        except Exception as error:
            # It never raises: somebody pressed it and must not be left with a traceback.
            self._link.say(f"the emergency stop failed: {error}")

    def go(self) -> None:
        """Releases the emergency stop and lets the node drive, also one that waits since it was started. Raises
        InputError with its reason."""
        self._link.go()

    # What is heard, in the link's thread.

    def _build(self) -> None:
        from rcl_interfaces.msg import ParameterEvent
        from tf2_msgs.msg import TFMessage

        from firstlap.ros.qos import LATCHED

        hear = self._link.node.create_subscription
        self._hear_trace()
        hear(TFMessage, "/tf_static", self._places.frames.hear, LATCHED)
        hear(TFMessage, "/tf", self._places.frames.hear, 100)
        hear(ParameterEvent, "/parameter_events", self._on_parameters, 100)
        self._hear_map()
        self._listen(self._link.value("scan_topic"), self._link.value("odom_topic"))
        self._base = self._link.value("base_frame")
        self._from_tf = bool(self._link.value("laser_from_tf"))

    def _hear_trace(self) -> None:
        """The status of each step, and every table that some driver has."""
        from diagnostic_msgs.msg import DiagnosticArray
        from sensor_msgs.msg import PointCloud2

        from firstlap.ros.qos import RECENT

        kinds = {STATUS: DiagnosticArray, **dict.fromkeys(TABLE_NAMES, PointCloud2)}
        for name, kind in kinds.items():
            topic = f"{self._link.path}/{TRACE}/{name}"
            self._link.node.create_subscription(kind, topic, partial(self.hear_trace, name), RECENT)

    def _hear_map(self) -> None:
        """The map, and where the car is in it."""
        from nav_msgs.msg import OccupancyGrid, Odometry
        from rclpy.qos import DurabilityPolicy, QoSProfile

        from firstlap.ros.qos import NEWEST

        node, latched = self._link.node, QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for one in self._of_map:
            node.destroy_subscription(one)
        self._of_map = [
            node.create_subscription(OccupancyGrid, MAP_TOPIC, self._on_map, latched),
            node.create_subscription(Odometry, TRUTH_TOPIC, self._places.hear_truth, NEWEST),
        ]
        self._map_asked = time.monotonic()
        self._map_tries += 1

    def _lacks_map(self) -> bool:
        """Somebody publishes what has not come: DDS loses a match now and then where processes were killed."""
        deaf = self._link.published(MAP_TOPIC) and not self._walls
        lost = self._link.published(TRUTH_TOPIC) and not self._places.in_map
        return deaf or lost

    def _map_is_due(self) -> bool:
        patience = min(MAP_LASTS * 2.0 ** max(self._map_tries - 1, 0), MAP_LONGEST)
        return time.monotonic() - self._map_asked > patience

    def _listen(self, scan: str, odom: str) -> None:
        """To the sensors, wherever they are now."""
        from nav_msgs.msg import Odometry
        from sensor_msgs.msg import LaserScan

        from firstlap.ros.qos import NEWEST

        for role, topic, kind, action in (
            ("scan", scan, LaserScan, self._on_scan),
            ("odom", odom, Odometry, self._places.hear_odometry),
        ):
            before = self._topics.get(role)
            if before and before[0] == topic:
                continue
            if before:
                self._link.node.destroy_subscription(before[1])
            self._topics[role] = (topic, self._link.node.create_subscription(kind, topic, action, NEWEST))

    def hear_trace(self, name: str, message: Any) -> None:
        """A part of a step, of the topic `name` under ~/trace. Never raises."""
        try:
            step = self._steps.hear(name, message)
        except ValueError as error:
            self._bad_trace = f"its trace cannot be read: {error}"
            return
        if step is None:
            return
        told, trace = step
        self._trace_at, self._bad_trace = time.monotonic(), ""
        if told.born != self._born:
            self._born, self._stale, self._asked = told.born, True, -math.inf
        self._show_trace(told, trace)

    def _show_trace(self, told: TraceHeader, trace: dict[str, Any]) -> None:
        places = self._places
        shown = trace or self._fresh_scan()
        near = clearance(points_of(shown, self._laser()), self.car)
        if near is not None and told.going:
            places.book.near(near)
        places.book.lap_setup.by(None if self._stale else self._setup)
        frame = Frame(
            self._next(), told.time, places.at(told.time), told.speed, told.yaw_rate, told.steering_angle,
            told.driver if trace else "", shown, told.step_us, clearance=places.book.clearance, laps=places.book.laps,
            going=told.going, said=self._with_trouble(told.said), sent=(told.sent_speed, told.sent_angle),
        )  # fmt: skip
        self._frame = frame

    def _show_without(self, why: str) -> None:
        """No trace comes: the newest scan, if there is one."""
        places, before = self._places, self._frame
        scan = self._fresh_scan()
        stamp, pose = places.newest()
        self._frame = Frame(
            self._next(), stamp, pose, places.speed, places.yaw_rate, before.steering_angle if before else 0.0,
            "", scan, 0.0, clearance=places.book.clearance, laps=places.book.laps,
            going=before.going if before else False, said=self._with_trouble(why if scan else f"{why}; no scan"),
        )  # fmt: skip

    def _fresh_scan(self) -> dict[str, Any]:
        return self._scan if time.monotonic() - self._scan_at < LOST else {}

    def _next(self) -> int:
        self._number += 1
        return self._number

    def _with_trouble(self, said: str) -> str:
        link = self._link
        unheard = "the emergency stop reaches nobody" if link.pressed and link.heard_by_nobody() else ""
        return "; ".join(one for one in (said, unheard, self._bad_trace, link.trouble) if one)

    def _on_scan(self, message: Any) -> None:
        """Kept for when the driver shows nothing."""
        scan, judgment = judged(message, self._mounted(message.header.frame_id), 0.0)
        if judgment.reason:
            return
        self._scan_at = time.monotonic()
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        good = scan.returns()
        self._scan = {"points": ray_ends(self._laser(), angles[good], scan.ranges[good])}
        if self._scan_at - self._trace_at >= LOST:
            self._show_without(self._why())

    def _mounted(self, frame: str) -> Mount:
        """As TF says; where it does not, straight ahead."""
        place = self._places.frames.find(self._base, frame) if self._from_tf else None
        try:
            if place is not None:
                mount = mount_of(place)
                set_laser(self.car.core, mount.x, mount.y)
                return mount
        except ValueError:
            pass  # a laser that leans: the driving node says so, here its scan is shown all the same
        return Mount(*self._laser(), 0.0, False)

    def _laser(self) -> tuple[float, float]:
        return laser_of(self.car.core.values()["geometry"])

    def _on_map(self, message: Any) -> None:
        from firstlap.ros.map_walls import walls_of

        try:
            self._walls = walls_of(message)
        except ValueError as error:
            self._link.say(str(error))

    # Who is there.

    def _look(self) -> None:
        if not self._lacks_map():
            self._map_tries = 0
        elif self._map_is_due():
            self._hear_map()
        there = self._link.there()
        self._stale = self._stale or (there and not self._was_there)
        if there and self._stale:
            self._fetch()
        self._was_there = there
        walls = self._walls if self._places.in_map else ()
        if walls is not self.scenery.walls and (walls or self.scenery.walls):
            self.scenery = Scenery(walls, (True,) * len(walls))
        now = time.monotonic()
        if now - self._trace_at >= LOST and now - self._scan_at >= LOST:
            self._show_without(self._why())

    def _why(self) -> str:
        """No trace comes."""
        silent = time.monotonic() - max(self._trace_at, self._began)
        gone = "" if self._was_there else f": no driving node {self._link.path}"
        return f"no trace for {silent:.1f} s{gone}"

    def _fetch(self) -> None:
        """Asks the node what it drives with; no oftener than once a second."""
        now = time.monotonic()
        if now - self._asked >= 1.0:
            self._asked = now
            self._link.fetch_told(self._on_told)

    def _on_told(self, told: dict[str, Any]) -> None:
        driver, name = told.get("driving_driver"), told.get("driving_setup")
        try:
            fields = driver_kind(str(driver)).fields.fields
        except InputError:
            self._link.say(f"{self._link.path} is no driving node that is known here")
            return
        self._listen(told["scan_topic"], told["odom_topic"])
        self._link.button_at(told["emergency_stop_topic"])
        self._base, self._from_tf = told["base_frame"], bool(told["laser_from_tf"])
        self._link.fetch(
            [field.key for field in fields], lambda values: self._on_values(str(driver), str(name), values)
        )

    def _on_values(self, driver: str, name: str, values: dict[str, Any]) -> None:
        fields = driver_kind(driver).fields.fields
        given = {
            (field.section, field.name): values[field.key]
            for field in fields
            if values.get(field.key) is not None and values[field.key] != field.default
        }
        self._setup = self._loaded = Setup(name, given, self._link.path, driver=driver)
        self._see_car()
        self._stale = False
        self._known.set()

    def _see_car(self) -> None:
        """The car that the setup tells of."""
        if "car" in self._setup.fields.sections:
            car = load_car("default")
            for field in self._setup.fields.fields:
                if field.section == "car":
                    car.core.set(car_section(field.name), field.name, self._setup.get(field.key))
            self.car = Car(self.title, car.core, self._link.path)

    def _on_parameters(self, event: Any) -> None:
        """Somebody else turned a knob of the node."""
        from rclpy.parameter import parameter_value_to_python

        if event.node != self._link.path or not self._known.is_set():
            return
        known = {field.key: field for field in self._setup.fields.fields}
        new = {
            known[one.name]: parameter_value_to_python(one.value)
            for one in event.changed_parameters
            if one.name in known
        }
        if new:
            self._taken(new)
