"""Planar poses: arrays (3,) or (N, 3) of x, y [m] and yaw [rad]."""

from __future__ import annotations

import numpy as np

from firstlap.tracks.track import FloatArray


def wrap(angle: FloatArray) -> FloatArray:
    """Wraps angles to [-pi, pi)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Transforms pose b from frame a to the parent frame of a."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, wrap(a[..., 2] + b[..., 2])], axis=-1)


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Pose b in the frame of pose a."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return np.stack([c * dx + s * dy, -s * dx + c * dy, wrap(b[..., 2] - a[..., 2])], axis=-1)


def transform(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Transforms points (N, 2) from the pose's frame to its parent frame."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + pose[:2])


def transform_cloud(pose: FloatArray, cloud: FloatArray) -> FloatArray:
    """Transforms a cloud (N, 4) of points and normals from the pose's frame to its parent frame."""
    turn = np.array([0.0, 0.0, pose[2]])
    return np.hstack([transform(pose, cloud[:, :2]), transform(turn, cloud[:, 2:])])
