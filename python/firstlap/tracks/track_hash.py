"""Identifies a track by its contents, independent of its file name."""

from __future__ import annotations

import hashlib

import numpy as np

from firstlap.tracks.track import Track


def track_hash(track: Track) -> str:
    """Hash of the arrays that the simulator uses."""
    digest = hashlib.sha256()
    for name, array in track.to_arrays().items():
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
