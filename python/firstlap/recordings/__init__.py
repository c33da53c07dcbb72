"""Reads recordings of real cars and of our own races, and writes logs.

>>> from firstlap.recordings import load_recording
>>> recording = load_recording("scan.npz")  # doctest: +SKIP
"""

from firstlap.recordings.load import load_recording
from firstlap.recordings.recording import Recording
from firstlap.recordings.topics import Topics

__all__ = ["Recording", "Topics", "load_recording"]
