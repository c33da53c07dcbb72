"""What a track is known by, whatever its file is called."""

from __future__ import annotations

import hashlib

import numpy as np

from firstlap.tracks.track import Track


def track_hash(track: Track) -> str:
    """Hash of what the simulator takes of a track."""
    digest = hashlib.sha256()
    for name, array in track.to_arrays().items():
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
