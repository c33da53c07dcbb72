"""Finds returns from the car itself, which do not change while the car drives."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from firstlap.config.setup_file import Setup
from firstlap.recordings.recording import Recording

SCANS = 300
MOVING, WAY = 0.3, 2.0
"""Minimum speed [m/s] of the scans used, and minimum distance [m] of the drive."""
SIDEWAYS, NEAR, SPREAD, OFTEN = 1.6, 0.7, 0.15, 0.3
"""Criteria for a beam that hits the car: minimum angle to the side [rad], maximum median range [m], maximum spread of
the range [m] (5th to 95th percentile), and minimum share of scans with a return."""
MARGIN_ANGLE, MARGIN_RANGE = 0.02, 0.05


class BodyMask(NamedTuple):
    """beams: number of beams that hit the car; mask_angle, mask_range: setup parameters that drop them."""

    beams: int
    mask_angle: float
    mask_range: float

    @property
    def assignments(self) -> str:
        """As command-line options."""
        return f"--set mask_angle={self.mask_angle:g} --set mask_range={self.mask_range:g}"


def find_body(recording: Recording, setup: Setup) -> BodyMask | None:
    """The mask that the recording's car needs; None if the setup's mask is sufficient, or if it cannot be determined.

    The car must have driven some distance, because at a standstill nothing changes.
    """
    size = Counter(len(one) for one in recording.ranges).most_common(1)[0][0]
    moving = np.flatnonzero(recording.speed > MOVING).tolist()
    driving = [i for i in moving if len(recording.ranges[i]) == size]
    if float(np.sum(np.abs(recording.speed) * recording.dts)) < WAY or len(driving) < 20:
        return None
    chosen = driving[:: -(-len(driving) // SCANS)]
    angle_min, angle_increment = recording.headers[chosen[0], :2]
    beams_at = angle_min + angle_increment * np.arange(size)
    angles = np.abs(np.remainder(beams_at + np.pi, 2.0 * np.pi) - np.pi)  # independent of where the scan begins
    sideways = np.flatnonzero(angles > SIDEWAYS)
    seen = [np.where(recording.scan(i).returns(), recording.ranges[i], np.nan)[sideways] for i in chosen]
    ranges = np.array(seen, dtype=np.float64)
    often = np.mean(np.isfinite(ranges), axis=0) >= OFTEN
    if not np.any(often):
        return None
    low, middle, high = np.nanpercentile(ranges[:, often], (5, 50, 95), axis=0)
    body = (middle < NEAR) & (high - low < SPREAD)
    beams = angles[sideways][often][body]
    mask_angle, mask_range = float(setup.get("mask_angle")), float(setup.get("mask_range"))
    reach = float(high[body].max()) + MARGIN_RANGE if len(beams) else 0.0
    if not len(beams) or (beams.min() >= mask_angle and reach - MARGIN_RANGE <= mask_range):
        return None
    return BodyMask(
        len(beams),
        min(mask_angle, round(float(beams.min()) - MARGIN_ANGLE, 2)),
        max(mask_range, round(reach, 2)),
    )
