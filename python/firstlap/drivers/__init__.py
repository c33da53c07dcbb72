"""Drivers: scan and state in, command out. `DRIVERS` knows them all."""

from firstlap.drivers.registry import DRIVERS, DriverKind, Handle, Preparation, driver_kind

__all__ = ["DRIVERS", "DriverKind", "Handle", "Preparation", "driver_kind"]
