"""Requests to a driving node, for machines without the `ros2` command."""

from __future__ import annotations

import difflib
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import yaml

from firstlap.common.errors import InputError
from firstlap.ros.persistent_stop import EMERGENCY

NODE = "firstlap_drive"
SERVICE_TIMEOUT = 5.0
"""[s] Timeout of service calls."""
RELEASE_DELAY = 1.0
"""[s] Maximum delay of a released emergency stop relative to a service call."""
SOON = 0.02


class NoNodeError(Exception):
    """No driving node responds."""


class Remote:
    """A client of the driving node in rclpy's namespace. patience: [s] discovery timeout."""

    def __init__(self, patience: float) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self._patience = patience
        self._node = rclpy.create_node(f"firstlap_remote_{os.getpid()}")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self.path = f"{self._node.get_namespace().rstrip('/')}/{NODE}"

    def close(self) -> None:
        """Destroys the node."""
        self._executor.remove_node(self._node)
        self._node.destroy_node()

    def _wait(self, over: Any, seconds: float) -> bool:
        until = time.monotonic() + seconds
        while not over():
            if time.monotonic() > until:
                return False
            self._executor.spin_once(timeout_sec=SOON)
        return True

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Calls a service of the node. Raises NoNodeError."""
        client = self._node.create_client(kind, f"{self.path}/{service}")
        try:
            if not self._wait(client.service_is_ready, self._patience):
                raise NoNodeError(
                    f"no driving node {self.path} within {self._patience:g} s: is `firstlap drive` running?"
                )
            future = client.call_async(request)
            if not self._wait(future.done, SERVICE_TIMEOUT):
                raise NoNodeError(
                    f"{self.path} did not respond within {SERVICE_TIMEOUT:g} s: "
                    "it is unknown whether the request was carried out"
                )
            return future.result()
        finally:
            self._node.destroy_client(client)

    def trigger(self, service: str) -> tuple[bool, str]:
        """Calls a std_srvs/Trigger; returns success and message. Raises NoNodeError."""
        from std_srvs.srv import Trigger

        answer = self.call(Trigger, service, Trigger.Request())
        return bool(answer.success), str(answer.message)

    def consent(self, service: str, release: bool) -> tuple[bool, str]:
        """Calls ~/go or ~/resume. release: first releases the emergency stop. Raises NoNodeError, InputError."""
        if release:
            self.emergency_stop(False)
        until = time.monotonic() + (RELEASE_DELAY if release else 0.0)
        while True:
            done, message = self.trigger(service)
            if message != EMERGENCY:
                return done, message
            if time.monotonic() > until:
                return False, f"{message}: release it first, for example with `firstlap {service} --release`"

    def emergency_stop(self, pressed: bool) -> None:
        """Publishes on the node's emergency stop topic. Raises NoNodeError, InputError."""
        from rclpy.duration import Duration
        from std_msgs.msg import Bool

        from firstlap.ros.qos import NEWEST_LATCHED

        topic = self._values(["emergency_stop_topic"])[0]
        if not topic:
            raise InputError(f"{self.path} has no emergency stop: its emergency_stop_topic is empty")
        publisher = self._node.create_publisher(Bool, topic, NEWEST_LATCHED)
        if not self._wait(lambda: publisher.get_subscription_count() > 0, self._patience):
            raise NoNodeError(f"no subscriber on {topic}")
        publisher.publish(Bool(data=pressed))
        if not publisher.wait_for_all_acked(Duration(seconds=SERVICE_TIMEOUT)):
            raise NoNodeError(f"{topic} was not acknowledged within {SERVICE_TIMEOUT:g} s")

    # Parameters.

    def _values(self, names: list[str]) -> list[Any]:
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        answer = self.call(GetParameters, "get_parameters", GetParameters.Request(names=names))
        return [parameter_value_to_python(value) for value in answer.values]

    def full_name(self, name: str) -> str:
        """The full name of a parameter: velocity_profile.v_max for v_max. Raises NoNodeError, InputError."""
        from rcl_interfaces.srv import ListParameters

        names = self.call(ListParameters, "list_parameters", ListParameters.Request()).result.names
        found = [one for one in names if name in (one, one.rpartition(".")[2])]
        if len(found) == 1 or name in found:
            return name if name in found else found[0]
        if found:
            raise InputError(f"{name} is ambiguous for {self.path}: {', '.join(sorted(found))}")
        near = difflib.get_close_matches(name, [*names, *(one.rpartition(".")[2] for one in names)], 1)
        raise InputError(f"{self.path} has no parameter {name[:60]}" + (f"; did you mean {near[0]}?" if near else ""))

    def set(self, name: str, text: str) -> tuple[str, Any, Any]:
        """Sets a parameter; returns full name, previous and new value. Raises NoNodeError, and InputError with the
        node's reason."""
        from rcl_interfaces.srv import SetParameters
        from rclpy.parameter import Parameter

        full = self.full_name(name)
        before = self._values([full])[0]
        value = value_like(before, full, text)
        request = SetParameters.Request(parameters=[Parameter(full, value=value).to_parameter_msg()])
        result = self.call(SetParameters, "set_parameters", request).results[0]
        if not result.successful:
            raise InputError(f"{full}: {self.path} refused {text[:60]}: {result.reason or 'no reason given'}")
        return full, before, value


def value_like(before: Any, name: str, text: str) -> Any:
    """Converts a value from the command line to the parameter's type. Raises InputError."""
    if isinstance(before, str):
        return text
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        value = None
    if isinstance(before, float) and type(value) in (int, float):
        return float(value)
    if type(value) is type(before):
        return value
    wanted = {bool: "true or false", int: "an integer", float: "a number"}.get(type(before), "another type")
    raise InputError(f"{name} is {wanted}, not '{text[:60]}'")


@contextmanager
def remote(patience: float) -> Iterator[Remote]:
    """A `Remote` within `process.ros`."""
    made = Remote(patience)
    try:
        yield made
    finally:
        made.close()
