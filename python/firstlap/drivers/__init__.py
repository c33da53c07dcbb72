"""Drivers: scan and state in, command out. `DRIVERS` knows them all."""

from firstlap.config.driver_kind import DRIVERS, DriverKind, Handle, Preparation, driver_kind

__all__ = ["DRIVERS", "DriverKind", "Handle", "Preparation", "driver_kind"]
