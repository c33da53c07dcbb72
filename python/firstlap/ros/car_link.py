"""A driving node seen from elsewhere: its topics, its parameters, its stops. In a thread and a context of its own."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from firstlap.common.errors import InputError
from firstlap.config.parameters import Field, Value
from firstlap.ros.names import DRIVE, TOLD
from firstlap.ros.node_parameters import declare_entries, value_of
from firstlap.ros.persistent_stop import EMERGENCY

ANSWERS = 1.0
"""[s] that a node may take to answer."""
SOON = 0.1
PRESSED_AGAIN = 0.1
"""[s] between two words of an emergency stop that is held: a node that starts meanwhile hears it too."""
SAID = 10.0
"""[s] that trouble is shown."""
OURS = ("scan_topic", "odom_topic", "emergency_stop_topic", "base_frame", "laser_from_tf")
"""Parameters of the driving node that whoever looks at it needs as well."""


class CarLink:
    """arguments: what follows --ros-args, with it; they give the namespace. name: of the driving node."""

    def __init__(self, arguments: list[str], name: str, domain: int | None = None) -> None:
        self._arguments, self._name, self._domain = arguments, name, domain
        self.pressed = False
        self._trouble = (0.0, "")
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._button: Any = None
        self._button_topic = ""
        self.node: Any = None
        self._context: Any = None
        self.path = name

    # A thread of its own.

    def start(self, build: Callable[[], object], look: Callable[[], object], period: float) -> None:
        """build: once, before anything is heard. look: every `period` [s]. Both run where callbacks do. Raises
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
            self.node.create_timer(period, look, clock=steady)
            self.node.create_timer(PRESSED_AGAIN, self._hold, clock=steady)
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
        self.button_at(self.value("emergency_stop_topic"))

    def _run(self) -> None:
        while not self._closing.is_set():
            self._spin()

    def _spin(self) -> None:
        try:
            self._executor.spin_once(timeout_sec=SOON)
        except Exception as error:
            # Whatever a message made go wrong: it is said, and the next message is heard.
            self.say(f"{type(error).__name__}: {error}")

    def say(self, trouble: str) -> None:
        """Something went wrong that only people can do something about."""
        self._trouble = (time.monotonic(), trouble[:200])

    @property
    def trouble(self) -> str:
        """What went wrong in the last seconds; empty when nothing did."""
        since, said = self._trouble
        return said if time.monotonic() - since < SAID else ""

    def close(self) -> None:
        """Leaves nothing running. The car is left as it is: one that was stopped stays so."""
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
        """One of `OURS`, as --ros-args gave it or by default."""
        return value_of(self.node, name)

    def published(self, topic: str) -> bool:
        """Whether anybody does."""
        return bool(self.node.count_publishers(topic))

    # What the node answers.

    def there(self) -> bool:
        """Whether a node of this name answers."""
        return bool(self._get.service_is_ready())

    def _need(self, client: Any) -> None:
        if self.node is None or not client.service_is_ready():
            raise InputError(f"no driving node {self.path}: nothing was changed")

    def _ask(self, client: Any, request: Any) -> Any:
        """From any thread but the link's own. Raises InputError."""
        self._need(client)
        answered = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(ANSWERS):
            client.remove_pending_request(future)
            raise InputError(f"{self.path} did not answer within {ANSWERS:g} s: whether it took that is not known")
        return future.result()

    def fetch(self, names: list[str], then: Callable[[dict[str, Any]], object]) -> None:
        """The node's parameters, handed to `then` in the link's thread; those that it does not have are missing."""
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        def on_answer(future: Any) -> None:
            values = future.result().values
            then({name: parameter_value_to_python(value) for name, value in zip(names, values, strict=False)})

        self._get.call_async(GetParameters.Request(names=names)).add_done_callback(on_answer)

    def fetch_told(self, then: Callable[[dict[str, Any]], object]) -> None:
        """What drives, and `OURS` as the node has them."""
        self.fetch([*(row.name for row in TOLD), *OURS], then)

    def set(self, values: Mapping[Field, Value]) -> None:
        """All of them or none. Raises InputError with the node's reason."""
        from rcl_interfaces.srv import SetParametersAtomically

        parameters = [_parameter(field, value) for field, value in values.items()]
        answer = self._ask(self._set, SetParametersAtomically.Request(parameters=parameters)).result
        if not answer.successful:
            raise InputError(answer.reason or f"{self.path} refused that, and said no reason")

    # Stops.

    def button_at(self, topic: str) -> None:
        """Where the emergency stop is said, latched; known before it is needed, so that it needs no time."""
        from std_msgs.msg import Bool

        from firstlap.ros.qos import NEWEST_LATCHED

        if topic == self._button_topic:
            return
        if self._button is not None:
            self.node.destroy_publisher(self._button)
        self._button_topic = topic
        self._button = self.node.create_publisher(Bool, topic, NEWEST_LATCHED) if topic else None

    def _press(self, down: bool) -> None:
        from std_msgs.msg import Bool

        if self._button is not None:
            self._button.publish(Bool(data=down))

    def _hold(self) -> None:
        if self.pressed:
            self._press(True)

    def heard_by_nobody(self) -> bool:
        """Whether an emergency stop would reach no one."""
        return self._button is None or self._button.get_subscription_count() == 0

    def stop(self) -> None:
        """Presses the emergency stop and holds it; also calls ~/stop."""
        from std_srvs.srv import Trigger

        self.pressed = True
        if self.node is not None:
            self._press(True)
            if self._stop.service_is_ready():
                self._stop.call_async(Trigger.Request())

    def go(self) -> None:
        """Releases the emergency stop and calls ~/go. Raises InputError with the node's reason; where there is no
        node, the stop stays pressed."""
        from std_srvs.srv import Trigger

        self._need(self._go)
        self.pressed = False
        self._press(False)
        until = time.monotonic() + ANSWERS
        while True:
            answer = self._ask(self._go, Trigger.Request())
            if answer.success:
                return
            # The button's release and this call come on different ways: the call may be first.
            if answer.message != EMERGENCY or time.monotonic() > until:
                raise InputError(f"{self.path} does not drive on: {answer.message}")
            time.sleep(0.02)


def _parameter(field: Field, value: Value) -> Any:
    """Of the type that the node declared; whether it is in range is for the node to say."""
    from rclpy.parameter import Parameter

    kind: type = {"bool": bool, "int": int}.get(field.type, float)
    try:
        if field.type == "int" and int(value) != value:
            raise ValueError
        return Parameter(field.key, value=kind(value)).to_parameter_msg()
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{field.key} is {str(value)[:60]}; allowed is {field.range}") from None
