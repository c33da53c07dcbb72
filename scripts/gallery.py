"""Draw the plots of docs/gallery.md: run the `firstlap explain` commands of the page, and shrink the images.

Usage: scripts/gallery.py   (commands whose map is missing on this machine are skipped; their plots stay unchanged)
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
    """Shrinks an image to half the size and few colors."""
    with Image.open(picture) as image:
        height = round(image.height * WIDTH / image.width)
        small = image.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
    small.quantize(COLORS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(picture, optimize=True)


def main() -> int:
    """Draws every plot. Exit code 1 if a command fails."""
    os.chdir(ROOT)
    for arguments in commands(PAGE.read_text(encoding="utf-8")):
        track = arguments[1]
        if track.endswith(".yaml") and not (ROOT / track).is_file():
            print(f"{track} is missing; its plot stays unchanged", file=sys.stderr)
            continue
        picture = ROOT / arguments[arguments.index("--plot") + 1]
        if run([*arguments[:-1], str(picture)]) != 0:
            return 1
        shrink(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
