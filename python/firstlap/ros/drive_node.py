"""The driving node: turns scans and odometry into drive commands. A managed (lifecycle) node.

When configured, it subscribes; when active, it drives. A person consents by ~/go or by activating it. A fault stops the
car until a person calls ~/resume.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from ackermann_msgs.msg import AckermannDriveStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from sensor_msgs.msg import Imu, JointState, Joy, LaserScan
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.drivers.driving import Driving
from firstlap.perception.frames import Frames, mount_of
from firstlap.perception.scan import USUAL_PERIOD, Mount
from firstlap.ros.claims import HEARTBEAT
from firstlap.ros.clock_watch import ClockWatch
from firstlap.ros.conversions import judged, seconds, set_stamp, sweep_of
from firstlap.ros.diagnostics import Health
from firstlap.ros.emergency import EmergencyStop
from firstlap.ros.markers import Markers
from firstlap.ros.names import DRIVE, IDENTITY
from firstlap.ros.node_parameters import declare_entries, declare_fields, declare_read_only, result, value_of
from firstlap.ros.odometry_watch import OdometryWatch
from firstlap.ros.other_drivers import OtherDrivers
from firstlap.ros.periods import BOUNDS, Period, rate_reason, timeout_of
from firstlap.ros.persistent_stop import EMERGENCY, PersistentStop
from firstlap.ros.qos import LATCHED, NEWEST
from firstlap.ros.safety import DEADMAN, DeadMan, Stamps, Watchdog, button_of, within
from firstlap.ros.traces import Traces
from firstlap.ros.vehicle_state import ESTIMATE_FIELDS, StateSource

NAME = "firstlap_drive"
CHECK_PERIOD = 0.02
"""[s] Period of the watchdog check, steady clock."""
STOPS_AFTER_DEACTIVATION = 25
"""Number of stop commands at this period after deactivation, before the node leaves the topic to others."""
STOPS_AT_EXIT, ACK_TIMEOUT = 3, 0.2
"""Number of stop commands when the node ends, and timeout [s] of their acknowledgment."""
CLOCK_STALL = 0.25
"""[s] Maximum time, by the steady clock, without progress of the simulated clock."""
RESTART_SILENCE = 0.5
"""[s] After this silence, a source may restart with any stamp."""
LONGEST_STEP = 1.0
"""[s] Maximum scan period passed to the driver."""

OK, REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class DriveNode(LifecycleNode):
    """driving: used unless the parameters `driver` or `setup` are set. Raises InputError."""

    def __init__(self, driving: Driving | None = None, **arguments: Any) -> None:
        super().__init__(NAME, **arguments)
        try:
            self._declare(driving)
        except ValueError as error:
            raise InputError(str(error)) from None
        self.health = Health(self)
        self.frames = Frames()
        self.state = StateSource(self, self.driving)
        self.deadman = DeadMan()
        self.watchdog = Watchdog({})
        self.watch = OdometryWatch()
        self.stamps = {name: Stamps(value_of(self, "max_age")) for name in BOUNDS}
        self.periods = {name: Period() for name in BOUNDS}
        self.steps = dict.fromkeys(BOUNDS, 0.0)
        self.mount: Mount | None = None
        self.mount_frame: str | None = None
        self.logged_remarks: set[str] = set()
        self.refusal = ""
        self.emergency = EmergencyStop(
            PersistentStop(self.get_fully_qualified_name(), self.context.get_domain_id()), self.trip
        )
        self.active = False
        self.stops_left = 0
        self.clock = ClockWatch(CLOCK_STALL)
        self._used_sim_time = bool(value_of(self, "use_sim_time"))
        self.own_subscriptions: list[Any] = []
        self.set_limits()
        self.add_on_set_parameters_callback(self.on_parameters)
        self.drive = self.create_publisher(AckermannDriveStamped, value_of(self, "drive_topic"), 1)
        self.other_drivers = OtherDrivers(self, value_of(self, "drive_topic"))
        self.markers = Markers(self)
        self.traces = Traces(self)

    def _declare(self, driving: Driving | None) -> None:
        declare_entries(self, DRIVE)
        driver, setup = value_of(self, "driver"), value_of(self, "setup")
        self.driving = Driving.of(driver, setup) if driver or setup or driving is None else driving
        declare_read_only(
            self, IDENTITY, {"driving_driver": self.driving.setup.driver, "driving_setup": self.driving.setup.name}
        )
        declare_fields(self, ESTIMATE_FIELDS.fields, lambda field: field.default)
        declare_fields(self, self.driving.fields, lambda field: self.driving.setup.get(field.key))
        self.driving.change({field.key: value_of(self, field.key) for field in self.driving.fields})

    # Parameters.

    def set_limits(self) -> None:
        """Updates the limits from the parameters."""
        self._set_timeouts()
        self.watchdog.pause_limit = value_of(self, "pause_limit")
        self.speed_limit = float(value_of(self, "speed_limit"))
        for stamps in self.stamps.values():
            stamps.max_age = value_of(self, "max_age")

    def _set_timeouts(self) -> None:
        """Sets the timeouts from the current periods. A period that grows while driving does not extend them."""
        timeouts = {}
        for source, bounds in BOUNDS.items():
            if value_of(self, f"{source}_topic"):
                given = value_of(self, "scan_timeout" if source == "scan" else "odom_timeout")
                timeouts[source] = timeout_of(given, self.periods[source].seconds, bounds)
        if value_of(self, "deadman_topic"):
            timeouts[DEADMAN] = value_of(self, "deadman_timeout")
        self.watchdog.timeouts = timeouts

    def _rate_reason(self) -> str:
        """Which source is too slow for driving; empty if none is."""
        timeouts = self.watchdog.timeouts
        reasons = (
            rate_reason(name, one.seconds, timeouts[name]) for name, one in self.periods.items() if name in timeouts
        )
        return next(filter(None, reasons), "")

    def on_parameters(self, parameters: list[Any]) -> Any:
        """Parameter callback: accepts all new values, or none with the reason."""
        known = {field.key for field in self.driving.fields}
        values = {parameter.name: parameter.value for parameter in parameters if parameter.name in known}
        try:
            if values:
                self.driving.change(values)
        except InputError as error:
            return result(str(error))
        if any(parameter.name.startswith(("state_estimate.", "car.")) for parameter in parameters):
            self._soon(self.state.set_estimate)
        if len(values) < len(parameters):
            self._soon(self.set_limits)
        return result()

    def _soon(self, action: Any) -> None:
        """Runs `action` after the current callback, when the parameters are set."""

        def once() -> None:
            self.destroy_timer(timer)
            action()

        timer = self.create_timer(0.0, once, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # Lifecycle.

    def _topic(self, role: str) -> str:
        return str(value_of(self, f"{role}_topic"))

    def on_configure(self, state: Any) -> Any:
        """Subscribes to all inputs; publishes no commands yet."""
        topic = self._topic
        subscribe = self.create_subscription
        self.own_subscriptions = [
            subscribe(LaserScan, topic("scan"), self.on_scan, NEWEST),
            subscribe(Odometry, topic("odom"), self.on_odometry, NEWEST),
            subscribe(TFMessage, "/tf_static", self.frames.add, LATCHED),
            subscribe(TFMessage, "/tf", self.frames.add, 100),
        ]
        if topic("imu"):
            self.own_subscriptions.append(subscribe(Imu, topic("imu"), self.on_imu, NEWEST))
        if topic("steering"):
            self.own_subscriptions.append(subscribe(JointState, topic("steering"), self.on_steering, NEWEST))
        self.emergency.listen(self, topic("emergency_stop"))
        if topic("deadman"):
            kind = Bool if value_of(self, "deadman_button") < 0 else Joy
            self.own_subscriptions.append(subscribe(kind, topic("deadman"), self.on_deadman, NEWEST))
        self.own_services = [
            self.create_service(Trigger, "~/go", self.on_go),
            self.create_service(Trigger, "~/resume", self.on_resume),
            self.create_service(Trigger, "~/stop", self.on_stop),
        ]
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.own_timers = [
            self.create_timer(CHECK_PERIOD, self.on_check, clock=steady),
            self.create_timer(1.0, self.health.publish, clock=steady),
            self.create_timer(HEARTBEAT, self.on_heartbeat, clock=steady),
        ]
        if value_of(self, "check_odometry"):
            self.watch.start()
        self.get_logger().info(f"speed_limit: no command is faster than {self.speed_limit:g} m/s")
        if self.emergency.previous:
            self.get_logger().warning(
                f"{self.emergency.consent_reason()}: the car stays stopped until a person gives consent"
            )
        return OK

    def on_activate(self, state: Any) -> Any:
        """Activation is a person's consent to drive. Refused while an input is missing."""
        self.refusal = self.arm()
        if self.refusal:
            self.get_logger().error(f"not driving: {self.refusal}")
            return REFUSED
        self.driving.reset()
        self.active = True
        self.emergency.drives(True)
        self.get_logger().info(f"driving: {self.driving.setup.title}, at most {self.speed_limit:g} m/s")
        return OK

    def on_deactivate(self, state: Any) -> Any:
        """Stops the car, and soon afterward leaves the drive topic to others."""
        self.active = False
        self.watchdog.disarm()
        self.stops_left = STOPS_AFTER_DEACTIVATION
        self.publish_stop()
        self.emergency.drives(False)
        return OK

    def on_cleanup(self, state: Any) -> Any:
        """Removes all subscriptions, services and timers."""
        for one in self.own_subscriptions:
            self.destroy_subscription(one)
        for one in self.own_services:
            self.destroy_service(one)
        for one in self.own_timers:
            self.destroy_timer(one)
        self.emergency.leave(self)
        self.watch.stop()
        self.own_subscriptions = []
        return OK

    def on_shutdown(self, state: Any) -> Any:
        """Stops the car."""
        self.halt()
        return OK

    def on_error(self, state: Any) -> Any:
        """Stops the car after any error."""
        self.halt()
        return OK

    def halt(self) -> None:
        """Stops the car and waits briefly for the acknowledgment."""
        was_active, self.active = self.active, False
        self.watchdog.disarm()
        if was_active or self.stops_left:
            for _ in range(STOPS_AT_EXIT):
                self.publish_stop()
            self.emergency.drives(False)
            self.other_drivers.claim(False)
            self.drive.wait_for_all_acked(Duration(seconds=ACK_TIMEOUT))
        self.watch.stop()  # last, because it joins its thread

    # Time.

    def now(self) -> float:
        """Time [s] of the clock of the stamps."""
        return float(self.get_clock().now().nanoseconds) * 1e-9

    def watch_now(self) -> float:
        """Time [s] of the clock for timeouts: it cannot jump, unless the time is simulated."""
        return self.now() if self._used_sim_time else time.monotonic()

    def _clock_reason(self) -> str:
        """Why the simulated clock is invalid; empty if it is valid."""
        return self.clock.reason(time.monotonic()) if self._used_sim_time else ""

    def check_timeouts(self) -> None:
        """Reads the clocks, and stops the car if a clock, a source or the node itself has timed out. Call often.

        While the car may not drive, the timeouts follow the measured periods.
        """
        steady = time.monotonic()
        self.clock.update(self.now(), steady)
        if not self.watchdog.armed:
            self._set_timeouts()
        elif self._clock_reason():
            self.trip(self._clock_reason())
        armed = self.watchdog.armed
        reason = self.watchdog.check(self.watch_now(), steady)
        if reason and armed:
            self._log_stop(reason)

    # Consent and stops.

    def arm(self) -> str:
        """Arms the watchdog: returns why the car may not drive; empty if it drives from now on."""
        self.check_timeouts()
        reason = EMERGENCY if self.emergency.pressed else self.ready()
        reason = reason or ("dead-man released" if DEADMAN in self.watchdog.timeouts and not self.deadman.held else "")
        reason = reason or self.watchdog.arm(self.watch_now())
        if not reason:
            self.other_drivers.claim(True)
        return reason

    def ready(self) -> str:
        """What is missing before the car could drive; empty if nothing is."""
        missing = self._clock_reason() or self.watchdog.missing(self.watch_now()) or self._mount_reason()
        return missing or self._rate_reason() or self.other_drivers.reason(False) or self.watch.reason

    def may_go(self) -> str:
        """Why the parameter `go` does not start the node now; empty if it does."""
        return self.emergency.consent_reason() or self.ready()

    def may_drive(self) -> bool:
        """Whether a person gave consent and the last check found no reason to stop."""
        return self.active and self.watchdog.armed

    def trip(self, reason: str) -> None:
        """Stops the car until a person gives consent again."""
        was_armed, reason = self.watchdog.armed, self.watchdog.trip(reason)
        if self.active:
            self.publish_stop()
        if was_armed:
            self._log_stop(reason)

    def _log_stop(self, reason: str) -> None:
        service = f"{self.get_fully_qualified_name()}/resume"
        self.get_logger().error(f"stopped: {reason}; continue with `firstlap resume` or the service {service}")
        self.health.publish()

    def on_go(self, request: Any, response: Any) -> Any:
        """~/go: a person's consent, for an inactive or a stopped node."""
        if self.active:
            return self.on_resume(request, response)
        self.trigger_activate()
        response.success, response.message = self.active, "driving" if self.active else self.refusal
        return response

    def on_resume(self, request: Any, response: Any) -> Any:
        """~/resume: a person's consent after a stop."""
        if self.watchdog.armed:
            response.success, response.message = True, "driving already"
            return response
        reason = self.arm() if self.active else "the node is not active: activate it, or call ~/go"
        response.success, response.message = not reason, reason or "driving"
        if not reason:
            self.driving.reset()
            self.get_logger().info("driving again")
        return response

    def on_stop(self, request: Any, response: Any) -> Any:
        """~/stop: stops the car, like one press of the emergency stop."""
        self.trip("~/stop was called")
        response.success, response.message = True, "stopped"
        return response

    def on_deadman(self, message: Any) -> None:
        """Handles the dead-man's switch: held, released, or pressed again."""
        now = self.watch_now()
        trusted = self.watchdog.silent(DEADMAN, now) <= self.watchdog.timeouts[DEADMAN]
        held, reason = button_of(message, value_of(self, "deadman_button"))
        if reason:
            self.watchdog.reject(DEADMAN, reason)
            return
        fresh = self.deadman.press(held, trusted)
        self.watchdog.feed(DEADMAN, now)
        if not held:
            self.trip("dead-man released")
        elif fresh and self.active and not self.watchdog.armed and _is_deadman_stop(self.watchdog.tripped):
            reason = self.arm()
            self.get_logger().info(f"dead-man pressed: {reason or 'driving'}")

    def on_heartbeat(self) -> None:
        """Publishes the claim to the topic, and yields to a node with precedence."""
        self.emergency.check_publishers(self)
        drives = self.may_drive()
        self.other_drivers.claim(drives)
        reason = self.other_drivers.reason(True) if drives else ""
        if reason:
            self.trip(reason)
            self.trigger_deactivate()
            self.stops_left = 0  # the topic belongs to the other node: a stop among its commands would brake the car

    def on_check(self) -> None:
        """Checks timeouts and odometry, and repeats the stop command while stopped."""
        for remark in self.watch.take_news():
            self.get_logger().warning(remark)
        if self.watch.reason:
            self.trip(self.watch.reason)
        self.check_timeouts()
        if self.active:
            if not self.may_drive():
                self.publish_stop()
        elif self.stops_left > 0:
            self.stops_left -= 1
            self.publish_stop()
        if not self.watchdog.armed:
            self.traces.publish_stopped()

    # Sources.

    def _take(self, source: str, message: Any, reason: str, took: float = 0.0) -> bool:
        """Whether a message may be used; updates the watchdog. took: [s] duration of the measurement."""
        now = self.watch_now()
        if self.watchdog.silent(source, now) > RESTART_SILENCE:
            self.stamps[source].forget()
            self.periods[source].forget()
        stamp = seconds(message.header.stamp)
        reason = reason or self.stamps[source].reason(stamp, self.now(), took)
        if reason:
            self.watchdog.reject(source, reason)
            return False
        self.stamps[source].take(stamp)
        self.watchdog.feed(source, now)
        self.steps[source] = self.periods[source].add(stamp)
        return True

    def _when(self, message: Any) -> float:
        """Time [s] of a message: its stamp, or now if the sensors' clocks differ."""
        return seconds(message.header.stamp) if self.stamps["scan"].max_age > 0.0 else self.now()

    def on_odometry(self, message: Any) -> None:
        """Takes speed and yaw rate."""
        twist = message.twist.twist
        if self._take("odom", message, self.state.odometry_reason(twist)):
            self.health.count("odom")
            self.state.add_odometry(seconds(message.header.stamp), twist)
            self.watch.add_odometry(self._when(message), twist, message.pose.pose)

    def on_imu(self, message: Any) -> None:
        """Takes the yaw rate."""
        if self._take("imu", message, self.state.imu_reason(message)):
            self.state.add_imu(seconds(message.header.stamp), message)
            self.watch.add_yaw_rate(message.angular_velocity.z)

    def on_steering(self, message: Any) -> None:
        """Takes the steering angle."""
        if self._take("steering", message, self.state.steering_reason(message)):
            self.state.add_steering(seconds(message.header.stamp), message)

    def _mount_reason(self) -> str:
        """Why the LiDAR mounting is unknown; empty if it is known."""
        return "" if self.mount else self.watchdog.rejected.get("scan", "no scan yet")

    def _mount_in(self, frame: str) -> tuple[Mount | None, str]:
        """The LiDAR mounting of scans in this frame, or None and why it is unknown. Raises InputError, ValueError."""
        if self.mount and frame == self.mount_frame:
            return self.mount, ""
        base = value_of(self, "base_frame")
        if value_of(self, "laser_from_tf"):
            place = self.frames.find(base, frame)
            if place is None:
                return None, f"no transform from {base} to {frame or 'the empty frame of the scan'}"
            return mount_of(place), ""
        if self.mount_frame is not None and frame != self.mount_frame:
            return None, f"the scan's frame changed from {self.mount_frame} to {frame}"
        return Mount(*self.driving.laser_given, float(value_of(self, "laser_yaw")), False), ""

    def _set_mount(self, frame: str) -> str:
        """Sets the LiDAR mounting for scans in this frame. Returns why that fails; empty if it does not."""
        try:
            mount, reason = self._mount_in(frame)
            if mount and frame != self.mount_frame:
                self.driving.mount(mount)
        except (ValueError, InputError) as error:
            return str(error)
        if mount:
            self.mount, self.mount_frame = mount, frame
        return reason

    def _read(self, message: Any, mount: Mount) -> tuple[_core.LaserScan | None, str]:
        """The converted scan, and why it must not be used; empty if it may."""
        scan, found = judged(message, mount, self.periods["scan"].seconds)
        self._remark(found.remarks)
        return scan, found.reason

    def _remark(self, remarks: Iterable[str]) -> None:
        """Logs each kind of remark once; remarks of later scans differ only in numbers."""
        for remark in remarks:
            about = remark.partition(" ")[0]
            if about not in self.logged_remarks:
                self.logged_remarks.add(about)
                self.get_logger().warning(remark)

    def on_scan(self, message: Any) -> None:
        """The control loop: one scan in, one command out."""
        began = time.perf_counter()
        reason = self._set_mount(message.header.frame_id)
        scan: _core.LaserScan | None = None
        if self.mount and not reason:
            scan, reason = self._read(message, self.mount)
        period = self.periods["scan"].seconds
        sweep = sweep_of(message, period)
        if not self._take("scan", message, reason, max(sweep, period)):
            return
        stamp, dt = seconds(message.header.stamp), self.steps["scan"]
        self.health.scan(dt, self.periods["scan"].seconds)
        if scan and self.mount:
            self.watch.add_scan(scan, self._when(message) + sweep, self.mount)
        self.check_timeouts()
        if not (self.may_drive() and scan):
            self.state.release()
            return
        speed, yaw_rate, steering_angle = self.state.now()
        before = time.perf_counter()
        command = self.driving.step(scan, speed, yaw_rate, steering_angle, min(dt, LONGEST_STEP) or USUAL_PERIOD)
        spent = time.perf_counter() - before
        limited = within(command.speed, command.steering_angle, self.speed_limit, self.driving.steering_limit)
        if limited is None:
            self.trip(f"the driver's command is not finite ({command.status})")
            return
        self.publish_drive(*limited, message.header.stamp)
        now = self.now()
        end = min(stamp + sweep, now)  # some LiDAR drivers stamp the first beam, some the last
        self.health.step(spent, time.perf_counter() - began, now - end, command.status)
        self.markers.publish(self.driving.handle, stamp)
        self.traces.publish((speed, yaw_rate, steering_angle), end, spent, limited)

    def publish_drive(self, speed: float, steering_angle: float, stamp: Any = None) -> None:
        """Publishes a command, with the stamp of its scan, or now."""
        message = AckermannDriveStamped()
        message.header.frame_id = value_of(self, "base_frame")
        if stamp is None:
            set_stamp(message.header.stamp, self.now())
        else:
            message.header.stamp = stamp
        message.drive.speed, message.drive.steering_angle = speed, steering_angle
        self.state.add_command(speed, steering_angle)
        self.watch.add_command(self.now(), speed)
        self.drive.publish(message)

    def publish_stop(self) -> None:
        """Publishes speed 0 with the last steering angle, so that the car stays on its path."""
        self.publish_drive(0.0, self.state.commanded[1])


def _is_deadman_stop(reason: str) -> bool:
    """Whether a stop was only due to the dead-man's switch."""
    return reason.startswith(("dead-man", f"no {DEADMAN}"))
