"""A node of the tests: receives commands, changes parameters, calls services, presses buttons."""

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
"""[s] Maximum age of a current command."""
AGAIN = 2.0
"""[s] Time without a response after which a service is called again."""


class Heard(NamedTuple):
    """A command with its time of arrival [s, time.monotonic()]."""

    time: float
    speed: float
    steering_angle: float


class Probe:
    """Runs in its own context in a domain."""

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
        """Handles received messages."""
        self.executor.spin_once(timeout_sec=seconds)

    def hear_drive(self, topic: str) -> None:
        """Records the commands on a topic."""
        heard = self.commands.setdefault(topic, [])

        def on_drive(message: Any) -> None:
            heard.append(Heard(time.monotonic(), message.drive.speed, message.drive.steering_angle))

        self.node.create_subscription(AckermannDriveStamped, topic, on_drive, 10)

    def hear(self, kind: Any, topic: str, qos: Any = qos_profile_sensor_data) -> list[Any]:
        """Records the messages of a topic."""
        if topic not in self.messages:  # once: a second subscription would count every message twice
            self.messages[topic] = []
            self.node.create_subscription(kind, topic, self.messages[topic].append, qos)
        return self.messages[topic]

    def speed(self, topic: str = "/drive") -> float:
        """The last commanded speed; 0 before the first command."""
        return self.commands[topic][-1].speed if self.commands[topic] else 0.0

    def moves(self, topic: str = "/drive") -> bool:
        """Whether the current command is to move."""
        heard = self.commands[topic]
        return bool(heard) and heard[-1].speed > 0.5 and time.monotonic() - heard[-1].time < PRESENT

    def publisher(self, kind: Any, topic: str) -> Any:
        """A publisher with a subscriber."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(
                kind, topic, 1, event_callbacks=PublisherEventCallbacks(use_default_callbacks=False)
            )
            while self._publishers[topic].get_subscription_count() == 0:
                self.spin(0.01)
        return self._publishers[topic]

    def call(self, kind: Any, name: str, request: Any, again: bool = True, seconds: float = 60.0) -> Any:
        """Calls a service. again: it may be called twice."""
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
            if again and time.monotonic() - asked > AGAIN:  # the server has died, which discovery does not know yet
                asked = time.monotonic()
                futures.append(client.call_async(request))
            self.spin(0.01)
        return done[0].result()

    def trigger(self, name: str) -> Any:
        """Calls a std_srvs/Trigger."""
        return self.call(Trigger, name, Trigger.Request())

    def change_state(self, transition: int, name: str = "/firstlap_drive") -> bool:
        """Requests a lifecycle transition; returns whether it succeeded."""
        request = ChangeState.Request()
        request.transition.id = transition
        return bool(self.call(ChangeState, f"{name}/change_state", request, again=False).success)

    def set(self, node: str, **values: Any) -> list[str]:
        """Sets parameters (double underscores are dots); returns the reasons of refusals, empty if accepted."""
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
