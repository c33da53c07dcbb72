"""ROS parameters from the field tables: declared with range and description, refused with a reason."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from firstlap.config.parameters import Field
from firstlap.ros.names import Entry

UNBOUNDED = 1e9


def declare_entries(node: Any, entries: Iterable[Entry]) -> None:
    """Declares the rows of a table in `names`; values from a launch file replace the defaults. Raises ValueError."""
    for entry in entries:
        _declare(node, entry.name, entry.default, entry.doc, entry.min, entry.max, entry.fixed)


def declare_fields(node: Any, fields: Iterable[Field], values: Callable[[Field], Any]) -> None:
    """Declares the parameters of a driver as section.name, with the values `values(field)`. Raises ValueError."""
    for field in fields:
        doc = f"{field.doc} [{field.unit}]" if field.unit else field.doc
        _declare(node, field.key, values(field), doc, field.min, field.max, False)


def declare_read_only(node: Any, entries: Iterable[Entry], values: dict[str, str]) -> None:
    """Declares read-only rows, whose values are set by the node."""
    from rcl_interfaces.msg import ParameterDescriptor

    for entry in entries:
        descriptor = ParameterDescriptor(description=entry.doc, read_only=True)
        node.declare_parameter(entry.name, values[entry.name], descriptor, ignore_override=True)


def _declare(node: Any, name: str, default: Any, doc: str, low: float | None, high: float | None, fixed: bool) -> None:
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
    from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException

    descriptor = ParameterDescriptor(description=doc, read_only=fixed)
    if isinstance(default, float) and low is not None and high is not None:
        descriptor.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)]
    elif isinstance(default, int) and not isinstance(default, bool) and low is not None and high is not None:
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    try:
        node.declare_parameter(name, default, descriptor)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        allowed = "" if low is None else f"; expected {low:g} to {high:g}"
        raise ValueError(f"parameter {name}: {error}{allowed}") from None


def value_of(node: Any, name: str) -> Any:
    """A parameter's value."""
    return node.get_parameter(name).value


def result(reason: str = "") -> Any:
    """The result of a parameter callback: success, or refusal with a reason."""
    from rcl_interfaces.msg import SetParametersResult

    return SetParametersResult(successful=not reason, reason=reason)
