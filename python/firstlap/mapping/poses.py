"""Poses in the plane: arrays (3,) or (N, 3) of x, y [m] and yaw [rad]."""

from __future__ import annotations

import numpy as np

from firstlap.tracks.track import FloatArray


def wrap(angle: FloatArray) -> FloatArray:
    """Angles in [-pi, pi)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Pose b, given in frame a, in the frame that a is given in."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, wrap(a[..., 2] + b[..., 2])], axis=-1)


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Pose b as seen from pose a."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return np.stack([c * dx + s * dy, -s * dx + c * dy, wrap(b[..., 2] - a[..., 2])], axis=-1)


def transform(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 2) of the pose's frame in the frame that the pose is given in."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + pose[:2])


def transform_cloud(pose: FloatArray, cloud: FloatArray) -> FloatArray:
    """The same for a cloud (N, 4) of points and normals."""
    turn = np.array([0.0, 0.0, pose[2]])
    return np.hstack([transform(pose, cloud[:, :2]), transform(turn, cloud[:, 2:])])
