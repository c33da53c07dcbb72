"""Record the pit wall in a real browser: docs/pit_wall.webp (animated) and docs/pit_wall.png.

Usage: scripts/pit_wall_pictures.py FOLDER   (needs chromium; the race runs slowly, the recording plays in real time)
"""

import contextlib
import io
import itertools
import os
import pathlib
import subprocess
import sys
import time
from collections.abc import Iterator

from PIL import Image
from playwright.sync_api import Page, sync_playwright

CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
SIZE = {"width": 1440, "height": 900}
SHOWN = (1080, 675)
PACE = 0.2
"""Playback speed: slow enough for software rendering."""
WARM_UP = 12.0
"""[s] Race time before the recording starts."""
LENGTH = 7.0
"""[s] Race time that is recorded."""


@contextlib.contextmanager
def pit_wall(*arguments: str) -> Iterator[str]:
    """Starts a pit wall and yields its address."""
    firstlap = str(pathlib.Path(sys.executable).with_name("firstlap"))
    process = subprocess.Popen(
        [firstlap, "view", *arguments, "--no-open", "--port", "0"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        yield process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait()


def shots(page: Page, seconds: float) -> Iterator[tuple[float, Image.Image]]:
    """Screenshots of the page, as fast as possible, with their times."""
    begin = time.monotonic()
    while time.monotonic() - begin < seconds:
        yield time.monotonic() - begin, Image.open(io.BytesIO(page.screenshot())).convert("RGB")


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    with pit_wall("arena", "--setup", "race", "--pace", str(PACE)) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.goto(address)
        page.get_by_text("driving", exact=True).wait_for()
        warning = page.get_by_text("Software WebGL rendering detected")
        with contextlib.suppress(Exception):
            warning.wait_for(timeout=5000)
            page.locator(".mantine-Notification-closeButton").first.click()
        time.sleep(WARM_UP / PACE)
        taken = list(shots(page, LENGTH / PACE))
        browser.close()
    times = [time for time, _ in taken] + [LENGTH / PACE]
    durations = [round(1000 * PACE * (after - before)) for before, after in itertools.pairwise(times)]
    pictures = [picture.resize(SHOWN, Image.Resampling.LANCZOS) for _, picture in taken]
    taken[-1][1].save(folder / "pit_wall.png", optimize=True)
    pictures[0].save(
        folder / "pit_wall.webp", save_all=True, append_images=pictures[1:], duration=durations, loop=0, quality=60,
        method=6,
    )  # fmt: skip
    print(f"{len(pictures)} pictures of {LENGTH:g} s")


if __name__ == "__main__":
    main()
