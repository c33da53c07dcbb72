"""A node's process: clean shutdown on signals, and the main loops."""

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
"""[s] Polling period for signals."""
ASK_AGAIN = 0.5
"""[s] Period of attempts to start with the parameter `go`."""


class Ending:
    """Records the signal that asks the process to end; 0: none."""

    number = 0

    def __call__(self, number: int, frame: Any) -> None:
        self.number = number

    @property
    def exit_code(self) -> int:
        """130 after Ctrl-C, 0 otherwise: SIGTERM is how a launch file ends a node."""
        return 130 if self.number == signal.SIGINT else 0


@contextmanager
def ros(arguments: list[str]) -> Iterator[Ending]:
    """Runs rclpy with our signal handlers. arguments: ROS arguments from --ros-args on. Raises InputError."""
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
    """Spins until a signal arrives, then stops the car. The parameter `go` is consent for the first start only."""
    from rclpy.executors import SingleThreadedExecutor

    from firstlap.ros.node_parameters import value_of

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    if not value_of(node, "managed"):
        node.trigger_configure()
    go = bool(value_of(node, "go"))
    if not go:
        node.get_logger().info(
            f"waiting for consent: run `firstlap go`, or call the service {node.get_fully_qualified_name()}/go"
        )
    ask, last_reason = time.monotonic(), ""
    pause_gc()
    try:
        while not ending.number:
            executor.spin_once(timeout_sec=SOON)
            go = go and not node.active
            if not go or time.monotonic() < ask:
                continue
            ask = time.monotonic() + ASK_AGAIN
            waits_for = node.may_go()
            if waits_for and waits_for != last_reason:
                node.get_logger().info(f"waiting: {waits_for}")
            last_reason = waits_for
            if not waits_for:
                node.trigger_activate()
    finally:
        node.halt()
        executor.remove_node(node)
        node.destroy_node()


def pause_gc() -> None:
    """Excludes all current objects from garbage collection: a full collection while driving would take several scan
    periods."""
    gc.collect()
    gc.freeze()


def run_sim(node: SimNode, ending: Ending, over: Callable[[], bool]) -> None:
    """Runs at the real-time factor until a signal arrives or `over` returns true after a scan."""
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
