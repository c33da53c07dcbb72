"""Draw the pictures of docs/gallery.md: run the `firstlap explain` commands that stand there, and make them small.

Usage: scripts/gallery.py   (a command whose map is not on this machine is left out, its picture stays)
"""

import os
import pathlib
import re
import shlex
import sys

from PIL import Image

from firstlap.cli import run

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "gallery.md"
WIDTH = 1120
COLORS = 160


def commands(page: str) -> list[list[str]]:
    """The arguments of every `firstlap explain` line of the page."""
    return [shlex.split(line)[1:] for line in re.findall(r"^firstlap explain .*$", page, re.MULTILINE)]


def shrink(picture: pathlib.Path) -> None:
    """Half the pixels and few colors: such a picture needs no more."""
    with Image.open(picture) as image:
        height = round(image.height * WIDTH / image.width)
        small = image.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
    small.quantize(COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(picture, optimize=True)


def main() -> int:
    """Draw every picture; 1 when a command failed."""
    os.chdir(ROOT)
    for arguments in commands(PAGE.read_text(encoding="utf-8")):
        track = arguments[1]
        if track.endswith(".yaml") and not (ROOT / track).is_file():
            print(f"{track} is not here; its picture stays as it is", file=sys.stderr)
            continue
        picture = ROOT / arguments[arguments.index("--plot") + 1]
        if run([*arguments[:-1], str(picture)]) != 0:
            return 1
        shrink(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
