"""A node's process: signals that end it in order, and the loops that it runs."""

from __future__ import annotations

import gc
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firstlap.ros.drive_node import DriveNode
    from firstlap.ros.sim_node import SimNode

SOON = 0.1
"""[s] between two looks at the signals."""
ASK_AGAIN = 0.5
"""[s] between two attempts to start by itself."""


class Ending:
    """Whether a signal asked the process to end; 0 where none did."""

    number = 0

    def __call__(self, number: int, frame: Any) -> None:
        self.number = number

    @property
    def exit_code(self) -> int:
        """130 after Ctrl-C, 0 otherwise: SIGTERM is how a launch file ends a node."""
        return 130 if self.number == signal.SIGINT else 0


@contextmanager
def ros(arguments: list[str]) -> Iterator[Ending]:
    """rclpy with our signal handlers. arguments: what follows --ros-args, with it. Raises InputError."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    from firstlap.common.errors import InputError

    ending = Ending()
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:
        raise InputError(f"{' '.join(arguments)[:200]}: {str(error).splitlines()[0]}") from None
    before = {number: signal.signal(number, ending) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield ending
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        rclpy.try_shutdown()


def run_drive(node: DriveNode, ending: Ending) -> None:
    """Spins until a signal comes; stops the car before it returns. The parameter `go` is consent for once."""
    from rclpy.executors import SingleThreadedExecutor

    from firstlap.ros.node_parameters import value_of

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    if not value_of(node, "managed"):
        node.trigger_configure()
    go = bool(value_of(node, "go"))
    if not go:
        node.get_logger().info(
            f"waiting for a person: firstlap go, or the service {node.get_fully_qualified_name()}/go"
        )
    ask, said = time.monotonic(), ""
    pause_gc()
    try:
        while not ending.number:
            executor.spin_once(timeout_sec=SOON)
            go = go and not node.active
            if not go or time.monotonic() < ask:
                continue
            ask = time.monotonic() + ASK_AGAIN
            waits_for = node.may_go()
            if waits_for and waits_for != said:
                node.get_logger().info(f"waiting: {waits_for}")
            said = waits_for
            if not waits_for:
                node.trigger_activate()
    finally:
        node.halt()
        executor.remove_node(node)
        node.destroy_node()


def pause_gc() -> None:
    """What is there lasts as long as the process: a full collection of it, while the car drives, would take as long as
    several scans."""
    gc.collect()
    gc.freeze()


def run_sim(node: SimNode, ending: Ending, over: Callable[[], bool]) -> None:
    """Runs in real time, or a factor of it, until a signal comes or `over` says so after a scan."""
    from rclpy.executors import SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        while not ending.number:
            wait = min(node.due, node.publish_late()) - time.monotonic()
            executor.spin_once(timeout_sec=min(max(wait, 0.0), SOON))
            if node.tick_if_due() and over():
                return
    finally:
        executor.remove_node(node)
        node.destroy_node()
