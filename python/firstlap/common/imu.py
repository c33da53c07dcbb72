"""What a sensor_msgs/Imu measures, by REP 145."""

from __future__ import annotations

from collections.abc import Sequence

NOT_MEASURED = -1.0
"""First element of the covariance of a quantity that an IMU does not measure."""


def measures(covariance: Sequence[float]) -> bool:
    """Whether an IMU measures the quantity with this covariance (9 values)."""
    return covariance[0] != NOT_MEASURED
