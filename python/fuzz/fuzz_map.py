"""Fuzzes the map reader: any YAML header and any image bytes are read or refused with a one-line error."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["firstlap", "yaml"]):
    from firstlap.common.errors import InputError
    from firstlap.tracks.library import load_track
    from firstlap.tracks.map_header import parse_ros_map_yaml

FOLDER = Path(tempfile.mkdtemp())
GOOD = "image: image.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"


def attempt(read: object, *arguments: object) -> None:
    """Calls `read`, which may only raise an InputError with a one-line message."""
    try:
        read(*arguments)  # type: ignore[operator]
    except InputError as error:
        assert "\n" not in str(error)


def one_input(data: bytes) -> None:
    """Uses the bytes as a header, as an image with a valid header, or both."""
    provider = atheris.FuzzedDataProvider(data)
    kind = provider.ConsumeIntInRange(0, 2)
    if kind == 0:
        attempt(parse_ros_map_yaml, provider.ConsumeUnicodeNoSurrogates(2000), "map.yaml")
        return
    text = GOOD if kind == 1 else GOOD + provider.ConsumeUnicodeNoSurrogates(200)
    (FOLDER / "map.yaml").write_text(text, encoding="utf-8", errors="ignore")
    size = provider.ConsumeIntInRange(1, 24)
    pixels = provider.ConsumeBytes(size * size)
    header = b"P5 %d %d 255\n" % (size, size) if provider.ConsumeBool() else provider.ConsumeBytes(20)
    (FOLDER / "image.pgm").write_bytes(header + pixels)
    attempt(load_track, str(FOLDER / "map.yaml"))


atheris.Setup(sys.argv, one_input)
atheris.Fuzz()
