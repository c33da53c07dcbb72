"""Drivers: scan and state in, command out. `DRIVERS` is their registry.

A driver written in Python is registered lazily: its modules are imported at its first use.
"""

from firstlap.config.driver_kind import DRIVERS, DriverKind, Handle, Preparation, driver_kind
from firstlap.drivers.core_drivers import CORE_DRIVERS

__all__ = ["DRIVERS", "DriverKind", "Handle", "Preparation", "driver_kind"]


def _global() -> DriverKind:
    from firstlap.drivers.global_driver.kind import global_kind

    return global_kind()


for _kind in CORE_DRIVERS:
    DRIVERS.register(_kind)
DRIVERS.register_lazily("global", _global)
