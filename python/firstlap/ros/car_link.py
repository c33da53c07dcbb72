"""A client of a driving node: topics, parameters and stops. Runs in its own thread and ROS context."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field, Value
from firstlap.ros.names import DRIVE, IDENTITY
from firstlap.ros.node_parameters import declare_entries, value_of
from firstlap.ros.persistent_stop import EMERGENCY

SERVICE_TIMEOUT = 1.0
"""[s] Timeout of service calls."""
SOON = 0.1
STOP_PERIOD = 0.1
"""[s] Repetition period of a held emergency stop, for nodes that start later."""
PROBLEM_DURATION = 10.0
"""[s] Duration for which a problem is shown."""
OURS = ("scan_topic", "odom_topic", "emergency_stop_topic", "base_frame", "laser_from_tf")
"""Parameters of the driving node that this client needs."""


class CarLink:
    """arguments: ROS arguments from --ros-args on, including the namespace. name: of the driving node."""

    def __init__(self, arguments: list[str], name: str, domain: int | None = None) -> None:
        self._arguments, self._name, self._domain = arguments, name, domain
        self.pressed = False
        self._problem = (0.0, "")
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._stop_publisher: Any = None
        self._stop_topic = ""
        self.node: Any = None
        self._context: Any = None
        self.path = name

    # The thread.

    def start(self, build: Callable[[], object], check: Callable[[], object], period: float) -> None:
        """Starts the thread. build: called once, before any callback. check: called every `period` [s]. Raises
        InputError."""
        import rclpy
        from rclpy.clock import Clock, ClockType
        from rclpy.executors import SingleThreadedExecutor

        self._context = rclpy.Context()
        try:
            rclpy.init(args=self._arguments, context=self._context, domain_id=self._domain)
        except Exception as error:
            raise InputError(f"{' '.join(self._arguments)[:200]}: {str(error).splitlines()[0]}") from None
        try:
            self.node = rclpy.create_node(f"firstlap_view_{os.getpid()}", context=self._context)
            declare_entries(self.node, [row for row in DRIVE if row.name in OURS])
            space = self.node.get_namespace().rstrip("/")
            self.path = f"{space}/{self._name}"
            self._connect()
            build()
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self.node.create_timer(period, check, clock=steady)
            self.node.create_timer(STOP_PERIOD, self._hold, clock=steady)
        except ValueError as error:
            self.close()
            raise InputError(str(error)) from None
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._run, name="firstlap ros", daemon=True)
        self._thread.start()

    def _connect(self) -> None:
        from rcl_interfaces.srv import GetParameters, SetParametersAtomically
        from std_srvs.srv import Trigger

        client = self.node.create_client
        self._get = client(GetParameters, f"{self.path}/get_parameters")
        self._set = client(SetParametersAtomically, f"{self.path}/set_parameters_atomically")
        self._stop = client(Trigger, f"{self.path}/stop")
        self._go = client(Trigger, f"{self.path}/go")
        self.set_stop_topic(self.value("emergency_stop_topic"))

    def _run(self) -> None:
        while not self._closing.is_set():
            self._spin()

    def _spin(self) -> None:
        try:
            self._executor.spin_once(timeout_sec=SOON)
        except Exception as error:
            # An error in a callback is reported; the next message is still handled.
            self.report(f"{type(error).__name__}: {error}")

    def report(self, problem: str) -> None:
        """Reports a problem that needs a person's attention."""
        self._problem = (time.monotonic(), problem[:200])

    @property
    def problem(self) -> str:
        """The problem of the last seconds; empty if there was none."""
        since, problem = self._problem
        return problem if time.monotonic() - since < PROBLEM_DURATION else ""

    def close(self) -> None:
        """Ends the thread and the node. The car keeps its state: a stopped car stays stopped."""
        self._closing.set()
        if self._thread:
            self._thread.join(5.0)
            self._thread = None
        if self.node is not None:
            self.node.destroy_node()
            self.node = None
        if self._context is not None:
            self._context.try_shutdown()
            self._context = None

    def value(self, name: str) -> Any:
        """The value of one of `OURS`, from --ros-args or the default."""
        return value_of(self.node, name)

    def published(self, topic: str) -> bool:
        """Whether the topic has a publisher."""
        return bool(self.node.count_publishers(topic))

    # Requests to the node.

    def is_available(self) -> bool:
        """Whether the node is available."""
        return bool(self._get.service_is_ready())

    def _require(self, client: Any) -> None:
        if self.node is None or not client.service_is_ready():
            raise InputError(f"no driving node {self.path}: nothing was changed")

    def _ask(self, client: Any, request: Any) -> Any:
        """Calls a service. Not from the link's own thread. Raises InputError."""
        self._require(client)
        answered = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(SERVICE_TIMEOUT):
            client.remove_pending_request(future)
            raise InputError(
                f"{self.path} did not respond within {SERVICE_TIMEOUT:g} s: "
                "it is unknown whether the request was carried out"
            )
        return future.result()

    def fetch(self, names: list[str], then: Callable[[dict[str, Any]], object]) -> None:
        """Requests parameters of the node and passes them to `then` in the link's thread; unknown ones are missing."""
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        def on_answer(future: Any) -> None:
            values = future.result().values
            then({name: parameter_value_to_python(value) for name, value in zip(names, values, strict=False)})

        self._get.call_async(GetParameters.Request(names=names)).add_done_callback(on_answer)

    def fetch_identity(self, then: Callable[[dict[str, Any]], object]) -> None:
        """Requests the node's driver and setup, and its values of `OURS`."""
        self.fetch([*(row.name for row in IDENTITY), *OURS], then)

    def set(self, values: Mapping[Field, Value]) -> None:
        """Sets parameters, all or none. Raises InputError with the node's reason."""
        from rcl_interfaces.srv import SetParametersAtomically

        parameters = [_parameter(field, value) for field, value in values.items()]
        answer = self._ask(self._set, SetParametersAtomically.Request(parameters=parameters)).result
        if not answer.successful:
            raise InputError(answer.reason or f"{self.path} refused that without a reason")

    # Stops.

    def set_stop_topic(self, topic: str) -> None:
        """Sets the topic of the emergency stop (latched) in advance, so that a stop needs no discovery."""
        from std_msgs.msg import Bool

        from firstlap.ros.qos import NEWEST_LATCHED

        if topic == self._stop_topic:
            return
        if self._stop_publisher is not None:
            self.node.destroy_publisher(self._stop_publisher)
        self._stop_topic = topic
        self._stop_publisher = self.node.create_publisher(Bool, topic, NEWEST_LATCHED) if topic else None

    def _publish_stop(self, down: bool) -> None:
        from std_msgs.msg import Bool

        if self._stop_publisher is not None:
            self._stop_publisher.publish(Bool(data=down))

    def _hold(self) -> None:
        if self.pressed:
            self._publish_stop(True)

    def is_unheard(self) -> bool:
        """Whether nobody would receive an emergency stop."""
        return self._stop_publisher is None or self._stop_publisher.get_subscription_count() == 0

    def stop(self) -> None:
        """Presses and holds the emergency stop, and calls ~/stop."""
        from std_srvs.srv import Trigger

        self.pressed = True
        if self.node is not None:
            self._publish_stop(True)
            if self._stop.service_is_ready():
                self._stop.call_async(Trigger.Request())

    def go(self) -> None:
        """Releases the emergency stop and calls ~/go. Raises InputError with the node's reason; without a node, the
        stop stays pressed."""
        from std_srvs.srv import Trigger

        self._require(self._go)
        self.pressed = False
        self._publish_stop(False)
        until = time.monotonic() + SERVICE_TIMEOUT
        while True:
            answer = self._ask(self._go, Trigger.Request())
            if answer.success:
                return
            # The release (a topic) and this call (a service) may arrive in any order.
            if answer.message != EMERGENCY or time.monotonic() > until:
                raise InputError(f"{self.path} does not drive: {answer.message}")
            time.sleep(0.02)


def _parameter(field: Field, value: Value) -> Any:
    """The parameter message with the declared type; the node checks the range."""
    from rclpy.parameter import Parameter

    kind: type = {"bool": bool, "int": int}.get(field.type, float)
    try:
        if field.type == "int" and int(value) != value:
            raise ValueError
        return Parameter(field.key, value=kind(value)).to_parameter_msg()
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{field.key} is {str(value)[:60]}; expected {field.range}") from None
