"""A node of the tests: hears what is commanded, changes parameters, calls services, presses buttons."""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import rclpy
from ackermann_msgs.msg import AckermannDriveStamped
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import Trigger

PRESENT = 0.5
"""[s] that a command is of the present."""
AGAIN = 2.0
"""[s] without an answer after which a service is asked again."""


class Heard(NamedTuple):
    """A command: when it came [s, time.monotonic()], and what it asks for."""

    time: float
    speed: float
    steering_angle: float


class Probe:
    """In its own context of a domain."""

    def __init__(self, domain: int) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("probe", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.commands: dict[str, list[Heard]] = {}
        self.messages: dict[str, list[Any]] = {}
        self._clients: dict[str, Any] = {}
        self._publishers: dict[str, Any] = {}
        self.hear_drive("/drive")

    def spin(self, seconds: float) -> None:
        """Handles what comes."""
        self.executor.spin_once(timeout_sec=seconds)

    def hear_drive(self, topic: str) -> None:
        """Keeps the commands on a topic."""
        heard = self.commands.setdefault(topic, [])

        def on_drive(message: Any) -> None:
            heard.append(Heard(time.monotonic(), message.drive.speed, message.drive.steering_angle))

        self.node.create_subscription(AckermannDriveStamped, topic, on_drive, 10)

    def hear(self, kind: Any, topic: str, qos: Any = qos_profile_sensor_data) -> list[Any]:
        """The messages of a topic, as they come."""
        if topic not in self.messages:  # once: a second subscription would count every message twice
            self.messages[topic] = []
            self.node.create_subscription(kind, topic, self.messages[topic].append, qos)
        return self.messages[topic]

    def speed(self, topic: str = "/drive") -> float:
        """Last commanded; 0 before anything was."""
        return self.commands[topic][-1].speed if self.commands[topic] else 0.0

    def moves(self, topic: str = "/drive") -> bool:
        """Whether somebody commands it to move at present."""
        heard = self.commands[topic]
        return bool(heard) and heard[-1].speed > 0.5 and time.monotonic() - heard[-1].time < PRESENT

    def publisher(self, kind: Any, topic: str) -> Any:
        """A publisher that somebody listens to."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(
                kind, topic, 1, event_callbacks=PublisherEventCallbacks(use_default_callbacks=False)
            )
            while self._publishers[topic].get_subscription_count() == 0:
                self.spin(0.01)
        return self._publishers[topic]

    def call(self, kind: Any, name: str, request: Any, again: bool = True, seconds: float = 60.0) -> Any:
        """The answer of a service. again: may be asked twice."""
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        client = self._clients[name]
        deadline = time.monotonic() + seconds
        while not client.service_is_ready():
            assert time.monotonic() < deadline, f"no service {name}"
            self.spin(0.01)
        futures = [client.call_async(request)]
        asked = time.monotonic()
        while not (done := [future for future in futures if future.done()]):
            assert time.monotonic() < deadline, f"no answer from {name}"
            if again and time.monotonic() - asked > AGAIN:  # the one who was asked is dead, and nobody knows it yet
                asked = time.monotonic()
                futures.append(client.call_async(request))
            self.spin(0.01)
        return done[0].result()

    def trigger(self, name: str) -> Any:
        """Calls a std_srvs/Trigger."""
        return self.call(Trigger, name, Trigger.Request())

    def change_state(self, transition: int, name: str = "/firstlap_drive") -> bool:
        """Whether a lifecycle transition was made."""
        request = ChangeState.Request()
        request.transition.id = transition
        return bool(self.call(ChangeState, f"{name}/change_state", request, again=False).success)

    def set(self, node: str, **values: Any) -> list[str]:
        """Sets parameters (double underscores are dots); the reasons why not, empty where they were taken."""
        parameters = [Parameter(name=name.replace("__", "."), value=_value(value)) for name, value in values.items()]
        answer = self.call(SetParameters, f"{node}/set_parameters", SetParameters.Request(parameters=parameters))
        return [one.reason if not one.successful else "" for one in answer.results]

    def close(self) -> None:
        """Leaves the domain."""
        self.executor.remove_node(self.node)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def _value(value: Any) -> ParameterValue:
    if isinstance(value, bool):
        return ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=value)
    if isinstance(value, int):
        return ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=value)
    if isinstance(value, float):
        return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
    return ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
