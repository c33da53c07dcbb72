"""One request to a driving node from elsewhere: what the `ros2` command would say, for machines that have none."""

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
ANSWERS = 5.0
"""[s] that a node may take to answer."""
ORDER = 1.0
"""[s] in which a released emergency stop has arrived: it and a request come on different ways."""
SOON = 0.02


class NoNodeError(Exception):
    """No driving node answers."""


class Remote:
    """Of the driving node in the namespace that rclpy was given. patience: [s] to look for it."""

    def __init__(self, patience: float) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self._patience = patience
        self._node = rclpy.create_node(f"firstlap_remote_{os.getpid()}")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self.path = f"{self._node.get_namespace().rstrip('/')}/{NODE}"

    def close(self) -> None:
        """Leaves."""
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
        """The answer of one of the node's services. Raises NoNodeError."""
        client = self._node.create_client(kind, f"{self.path}/{service}")
        try:
            if not self._wait(client.service_is_ready, self._patience):
                raise NoNodeError(
                    f"no driving node {self.path} within {self._patience:g} s: is `firstlap drive` running?"
                )
            future = client.call_async(request)
            if not self._wait(future.done, ANSWERS):
                raise NoNodeError(f"{self.path} did not answer within {ANSWERS:g} s: whether it took that is not known")
            return future.result()
        finally:
            self._node.destroy_client(client)

    def trigger(self, service: str) -> tuple[bool, str]:
        """Calls a std_srvs/Trigger: whether it was done, and what the node says. Raises NoNodeError."""
        from std_srvs.srv import Trigger

        answer = self.call(Trigger, service, Trigger.Request())
        return bool(answer.success), str(answer.message)

    def consent(self, service: str, release: bool) -> tuple[bool, str]:
        """Calls ~/go or ~/resume. release: takes an emergency stop away before. Raises NoNodeError, InputError."""
        if release:
            self.emergency_stop(False)
        until = time.monotonic() + (ORDER if release else 0.0)
        while True:
            done, said = self.trigger(service)
            if said != EMERGENCY:
                return done, said
            if time.monotonic() > until:
                return False, f"{said}; it must be released first, for example by `firstlap {service} --release`"

    def emergency_stop(self, pressed: bool) -> None:
        """Says it on the topic that the node hears it on. Raises NoNodeError, InputError."""
        from rclpy.duration import Duration
        from std_msgs.msg import Bool

        from firstlap.ros.qos import NEWEST_LATCHED

        topic = self._values(["emergency_stop_topic"])[0]
        if not topic:
            raise InputError(f"{self.path} hears no emergency stop: its emergency_stop_topic is empty")
        publisher = self._node.create_publisher(Bool, topic, NEWEST_LATCHED)
        if not self._wait(lambda: publisher.get_subscription_count() > 0, self._patience):
            raise NoNodeError(f"nobody hears {topic}")
        publisher.publish(Bool(data=pressed))
        if not publisher.wait_for_all_acked(Duration(seconds=ANSWERS)):
            raise NoNodeError(f"{topic} was not acknowledged within {ANSWERS:g} s")

    # Parameters.

    def _values(self, names: list[str]) -> list[Any]:
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        answer = self.call(GetParameters, "get_parameters", GetParameters.Request(names=names))
        return [parameter_value_to_python(value) for value in answer.values]

    def full_name(self, name: str) -> str:
        """Of a parameter: v_max is velocity_profile.v_max. Raises NoNodeError, InputError."""
        from rcl_interfaces.srv import ListParameters

        names = self.call(ListParameters, "list_parameters", ListParameters.Request()).result.names
        found = [one for one in names if name in (one, one.rpartition(".")[2])]
        if len(found) == 1 or name in found:
            return name if name in found else found[0]
        if found:
            raise InputError(f"{name} is not one parameter of {self.path}: {', '.join(sorted(found))}")
        near = difflib.get_close_matches(name, [*names, *(one.rpartition(".")[2] for one in names)], 1)
        raise InputError(f"{self.path} has no parameter {name[:60]}" + (f"; did you mean {near[0]}?" if near else ""))

    def set(self, name: str, text: str) -> tuple[str, Any, Any]:
        """Full name, value before and after. Raises NoNodeError, and InputError with the node's reason."""
        from rcl_interfaces.srv import SetParameters
        from rclpy.parameter import Parameter

        full = self.full_name(name)
        before = self._values([full])[0]
        value = value_like(before, full, text)
        request = SetParameters.Request(parameters=[Parameter(full, value=value).to_parameter_msg()])
        result = self.call(SetParameters, "set_parameters", request).results[0]
        if not result.successful:
            raise InputError(f"{full}: {self.path} refuses {text[:60]}: {result.reason or 'it says no reason'}")
        return full, before, value


def value_like(before: Any, name: str, text: str) -> Any:
    """A value from the command line, of the type that the parameter has. Raises InputError."""
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
    wanted = {bool: "true or false", int: "a whole number", float: "a number"}.get(type(before), "another type")
    raise InputError(f"{name} is {wanted}, not '{text[:60]}'")


@contextmanager
def remote(patience: float) -> Iterator[Remote]:
    """Within `process.ros`."""
    made = Remote(patience)
    try:
        yield made
    finally:
        made.close()
