"""A real or simulated car over ROS 2: the trace of its driving node, or only its sensors without one."""

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
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.places import Places, clearance, points_of
from firstlap.pitwall.source_state import SourceState
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
"""[s] Without a trace for this time, a message and the plain scan are shown."""
CHECK_PERIOD = 0.1
"""[s] Period of the connection check."""
FIRST = 5.0
"""[s] Default time for which `start` waits for the driving node."""
MAP_LASTS, MAP_LONGEST = 2.0, 16.0
"""[s] Initial and maximum time to wait for the map before subscribing again; doubled each time."""


class RosSource(SourceState):
    """A `Source` that `Drives`. arguments: for ROS, from `ros_arguments`. node: name of the driving node. patience: [s]
    for which `start` waits for that node's setup.

    `close` leaves the car in its state: a car that was stopped here stays stopped.
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
        self._born, self._was_available, self._stale, self._asked = "", False, True, -math.inf
        self._trace_at = self._scan_at = self._began = -math.inf
        self._bad_trace = ""
        self._steps = TraceReader()
        self._mount: Mount | None = None
        self._scan: dict[str, Any] = {}
        self._topics: dict[str, Any] = {}

    # Source.

    def start(self) -> None:
        """Connects, and waits briefly for the driving node. Raises InputError without ROS 2."""
        require_ros()
        self._began = time.monotonic()
        self._link.start(self._build, self._check, CHECK_PERIOD)
        self.title = f"{self._link.path} over ROS 2"
        self._known.wait(self._patience)
        until = time.monotonic() + min(self._patience, MAP_LASTS)
        while self._link.published(MAP_TOPIC) and not self.scenery.walls and time.monotonic() < until:
            time.sleep(0.5 * CHECK_PERIOD)

    def close(self) -> None:
        """Disconnects."""
        self._link.close()

    def change(self, values: Mapping[str, Value]) -> None:
        """Changes parameters of the node, all or none. Raises InputError with the node's reason."""
        with self._changing:
            fields = self._setup.fields
            asked = {fields.find(name, "setup"): value for name, value in values.items()}
            self._link.set(asked)
            self._taken(asked)

    def choose(self, setup: Setup) -> None:
        """Sets all parameters of the node. Raises InputError for a setup of another driver."""
        if setup.driver != self._setup.driver:
            raise InputError(
                f"{self._link.path} runs the driver {self._setup.driver}: restart it with "
                f"`firstlap drive --driver {setup.driver} --setup {setup.source or setup.name}`"
            )
        self.change({field.key: setup.get(field.key) for field in setup.fields.fields})
        self._setup = self._loaded = setup

    def _taken(self, values: Mapping[Field, Value]) -> None:
        """Records values that the node has accepted."""
        new = {(field.section, field.name): value for field, value in values.items()}
        before = self._setup
        changed = replace(before, given={**before.given, **new}, changed={**before.changed, **new})
        self._setup = changed_from(changed, self._loaded)
        self._update_car()

    # Drives.

    def stop(self) -> None:
        """Presses the emergency stop until `go`, and calls ~/stop."""
        try:
            self._link.stop()
        except Exception as error:
            # Must not raise: whoever presses the stop must get a message, not a traceback.
            self._link.report(f"the emergency stop failed: {error}")

    def go(self) -> None:
        """Releases the emergency stop and lets the node drive, also one that was just started. Raises InputError with
        the node's reason."""
        self._link.go()

    # Callbacks, in the thread of the link.

    def _build(self) -> None:
        from rcl_interfaces.msg import ParameterEvent
        from tf2_msgs.msg import TFMessage

        from firstlap.ros.qos import LATCHED

        subscribe = self._link.node.create_subscription
        self._subscribe_trace()
        subscribe(TFMessage, "/tf_static", self._places.frames.add, LATCHED)
        subscribe(TFMessage, "/tf", self._places.frames.add, 100)
        subscribe(ParameterEvent, "/parameter_events", self._on_parameters, 100)
        self._subscribe_map()
        self._subscribe_sensors(self._link.value("scan_topic"), self._link.value("odom_topic"))
        self._base = self._link.value("base_frame")
        self._from_tf = bool(self._link.value("laser_from_tf"))

    def _subscribe_trace(self) -> None:
        """Subscribes to the status of each step and to the tables of all drivers."""
        from diagnostic_msgs.msg import DiagnosticArray
        from sensor_msgs.msg import PointCloud2

        from firstlap.ros.qos import RECENT

        kinds = {STATUS: DiagnosticArray, **dict.fromkeys(TABLE_NAMES, PointCloud2)}
        for name, kind in kinds.items():
            topic = f"{self._link.path}/{TRACE}/{name}"
            self._link.node.create_subscription(kind, topic, partial(self.on_trace, name), RECENT)

    def _subscribe_map(self) -> None:
        """Subscribes to the map and to the pose in it."""
        from nav_msgs.msg import OccupancyGrid, Odometry
        from rclpy.qos import DurabilityPolicy, QoSProfile

        from firstlap.ros.qos import NEWEST

        node, latched = self._link.node, QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for one in self._of_map:
            node.destroy_subscription(one)
        self._of_map = [
            node.create_subscription(OccupancyGrid, MAP_TOPIC, self._on_map, latched),
            node.create_subscription(Odometry, TRUTH_TOPIC, self._places.on_ground_truth, NEWEST),
        ]
        self._map_asked = time.monotonic()
        self._map_tries += 1

    def _lacks_map(self) -> bool:
        """Whether to subscribe again: a publisher exists but nothing arrived. DDS sometimes loses a match when
        processes were killed."""
        deaf = self._link.published(MAP_TOPIC) and not self._walls
        lost = self._link.published(TRUTH_TOPIC) and not self._places.in_map
        return deaf or lost

    def _map_is_due(self) -> bool:
        patience = min(MAP_LASTS * 2.0 ** max(self._map_tries - 1, 0), MAP_LONGEST)
        return time.monotonic() - self._map_asked > patience

    def _subscribe_sensors(self, scan: str, odom: str) -> None:
        """Subscribes to the sensors' current topics."""
        from nav_msgs.msg import Odometry
        from sensor_msgs.msg import LaserScan

        from firstlap.ros.qos import NEWEST

        for role, topic, kind, action in (
            ("scan", scan, LaserScan, self._on_scan),
            ("odom", odom, Odometry, self._places.on_odometry),
        ):
            before = self._topics.get(role)
            if before and before[0] == topic:
                continue
            if before:
                self._link.node.destroy_subscription(before[1])
            self._topics[role] = (topic, self._link.node.create_subscription(kind, topic, action, NEWEST))

    def on_trace(self, name: str, message: Any) -> None:
        """Takes a message of the topic `name` under ~/trace. Never raises."""
        try:
            step = self._steps.add(name, message)
        except ValueError as error:
            self._bad_trace = f"the trace cannot be read: {error}"
            return
        if step is None:
            return
        header, trace = step
        self._trace_at, self._bad_trace = time.monotonic(), ""
        if header.born != self._born:
            self._born, self._stale, self._asked = header.born, True, -math.inf
        self._show_trace(header, trace)

    def _show_trace(self, header: TraceHeader, trace: dict[str, Any]) -> None:
        places = self._places
        shown = trace or self._recent_scan()
        near = clearance(points_of(shown, self._laser()), self.car)
        if near is not None and header.going:
            places.book.near(near)
        places.book.lap_setup.by(None if self._stale else self._setup)
        frame = Frame(
            self._next(), header.time, places.at(header.time), header.speed, header.yaw_rate, header.steering_angle,
                        header.driver if trace else "", shown, header.step_us, clearance=places.book.clearance,
            laps=places.book.laps, may_drive=header.going, message=self._with_problems(header.said),
            sent=(header.sent_speed, header.sent_angle),
        )  # fmt: skip
        self._frame = frame

    def _show_without(self, why: str) -> None:
        """Shows the newest scan, if any, while there is no trace."""
        places, before = self._places, self._frame
        scan = self._recent_scan()
        stamp, pose = places.newest()
        self._frame = Frame(
            self._next(), stamp, pose, places.speed, places.yaw_rate, before.steering_angle if before else 0.0,
            "", scan, 0.0, clearance=places.book.clearance, laps=places.book.laps,
            may_drive=before.may_drive if before else False,
            message=self._with_problems(why if scan else f"{why}; no scan"),
        )  # fmt: skip

    def _recent_scan(self) -> dict[str, Any]:
        return self._scan if time.monotonic() - self._scan_at < LOST else {}

    def _next(self) -> int:
        self._number += 1
        return self._number

    def _with_problems(self, message: str) -> str:
        link = self._link
        unheard = "nobody receives the emergency stop" if link.pressed and link.is_unheard() else ""
        return "; ".join(one for one in (message, unheard, self._bad_trace, link.problem) if one)

    def _on_scan(self, message: Any) -> None:
        """Keeps the scan, in case the driver publishes no trace."""
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
        """The mounting from TF; without TF, facing forward."""
        place = self._places.frames.find(self._base, frame) if self._from_tf else None
        try:
            if place is not None:
                mount = mount_of(place)
                set_laser(self.car.core, mount.x, mount.y)
                return mount
        except ValueError:
            pass  # a tilted laser: the driving node reports it; the scan is shown anyway
        return Mount(*self._laser(), 0.0, False)

    def _laser(self) -> tuple[float, float]:
        return laser_of(self.car.core.values()["geometry"])

    def _on_map(self, message: Any) -> None:
        from firstlap.ros.map_walls import walls_of

        try:
            self._walls = walls_of(message)
        except ValueError as error:
            self._link.report(str(error))

    # The driving node.

    def _check(self) -> None:
        if not self._lacks_map():
            self._map_tries = 0
        elif self._map_is_due():
            self._subscribe_map()
        available = self._link.is_available()
        self._stale = self._stale or (available and not self._was_available)
        if available and self._stale:
            self._fetch()
        self._was_available = available
        walls = self._walls if self._places.in_map else ()
        if walls is not self.scenery.walls and (walls or self.scenery.walls):
            self.scenery = Scenery(walls, (True,) * len(walls))
        now = time.monotonic()
        if now - self._trace_at >= LOST and now - self._scan_at >= LOST:
            self._show_without(self._why())

    def _why(self) -> str:
        """Why no trace is shown."""
        silent = time.monotonic() - max(self._trace_at, self._began)
        gone = "" if self._was_available else f": no driving node {self._link.path}"
        return f"no trace for {silent:.1f} s{gone}"

    def _fetch(self) -> None:
        """Requests the node's driver and setup, at most once a second."""
        now = time.monotonic()
        if now - self._asked >= 1.0:
            self._asked = now
            self._link.fetch_identity(self._on_identity)

    def _on_identity(self, found: dict[str, Any]) -> None:
        driver, name = found.get("driving_driver"), found.get("driving_setup")
        try:
            fields = driver_kind(str(driver)).fields.fields
        except InputError:
            self._link.report(f"{self._link.path} runs a driver that is unknown here")
            return
        self._subscribe_sensors(found["scan_topic"], found["odom_topic"])
        self._link.set_stop_topic(found["emergency_stop_topic"])
        self._base, self._from_tf = found["base_frame"], bool(found["laser_from_tf"])
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
        self._update_car()
        self._stale = False
        self._known.set()

    def _update_car(self) -> None:
        """Updates the car from the setup's section `car`."""
        if "car" in self._setup.fields.sections:
            car = load_car("default")
            for field in self._setup.fields.fields:
                if field.section == "car":
                    car.core.set(car_section(field.name), field.name, self._setup.get(field.key))
            self.car = Car(self.title, car.core, self._link.path)

    def _on_parameters(self, event: Any) -> None:
        """Takes parameters of the node that someone else changed."""
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
