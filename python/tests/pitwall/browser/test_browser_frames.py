"""Each rendered frame of the pit wall shows one step: the car, its perception and its plan."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from sight import PLACES, Sight

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.pitwall.app import App, serve
from firstlap.pitwall.authentication import Authenticator
from firstlap.pitwall.camera import FOLLOW, FREE, TURN
from firstlap.pitwall.frame import Frame, Scenery
from firstlap.plots.colors import INK, LEFT, LINE, rgb

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
STANDS = ((-0.75, 0.0, 0.0), (0.75, 0.25, 0.0))
"""The car's two alternating poses [m, rad]."""
YARD = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0], [-4.0, -4.0]])
COLORS = {"car": rgb(INK), "cloud": rgb(LEFT), "line": rgb(LINE)}
PERIOD = 0.1
"""[s] Period of the steps."""
FRAMES = 60
TOLERANCE = 6.0
"""[pixels] Tolerance of the center of a rasterized drawing; a step moves it by 30 pixels or more."""


class Jumping:
    """A source whose car changes its pose at every step, with the same perception and plan in its frame."""

    title = "jumping"
    scenery = Scenery((YARD,), (False,))

    def __init__(self) -> None:
        self.car, self.setup = load_car("default"), load_setup("sure")
        self.loaded = self.setup
        seen = np.column_stack([np.linspace(-1.0, 1.0, 40), np.full(40, 1.0)])
        line = np.column_stack([np.linspace(-1.0, 1.0, 20), np.full(20, -0.8)])
        self._trace = {
            "points": seen,
            "sections": {"first": [0], "last": [len(seen) - 1], "status": [0]},
            "split": 0,
            "line": {"points": line},
            "result": (1.0, 0.2, "ok"),
        }
        self._lock, self._began = threading.Lock(), time.monotonic()

    def latest(self) -> Frame:
        """The frame for the current time."""
        number = int((time.monotonic() - self._began) / PERIOD)
        pose = STANDS[number % len(STANDS)]
        return Frame(number, PERIOD * number, pose, 1.0, 0.0, 0.2, "local", self._trace, 100.0)

    def start(self) -> None:
        """Does nothing."""

    close = start

    def change(self, values: Any) -> None:
        """Does nothing."""

    choose = change


@pytest.fixture(scope="module")
def watched(browser: Browser) -> Iterator[tuple[App, Sight]]:
    """Opens a page."""
    source, authenticator = Jumping(), Authenticator()
    app = serve(source, port=0, authenticator=authenticator)
    sight = Sight(browser, authenticator.url, 1250, fine=0.5, script=PLACES).ready()
    yield app, sight
    sight.close()
    app.close()


def middles(places: list[Any]) -> dict[str, np.ndarray]:
    """Centers (frames, 2) [pixels] of each color; NaN if it is not visible."""
    return {name: np.array([(place[name] or [np.nan] * 3)[:2] for place in places]) for name in COLORS}


def spread(places: np.ndarray) -> np.ndarray:
    """Deviation (frames,) [pixels] from the median; infinite if something is not visible."""
    return np.nan_to_num(np.abs(places - np.nanmedian(places, axis=0)).max(axis=1), nan=np.inf)


def settled(places: list[Any]) -> bool:
    """Whether everything is visible and the camera no longer moves."""
    seen = all(place[name] for place in places for name in COLORS)
    at = middles(places) if seen and len(places) == 8 else {}
    return bool(at) and bool(spread(at["line"] - at["cloud"]).max() < 1.0)


@pytest.mark.parametrize("mode", [FREE, FOLLOW, TURN])
def test_car_cloud_and_line_of_a_picture_are_of_one_step(watched: tuple[App, Sight], mode: str) -> None:
    app, sight = watched
    sight.until(lambda: len(app._viewpoints) == 1)
    for viewpoint in app._viewpoints.values():
        viewpoint.overview() if mode == FREE else viewpoint.choose(mode)
    sight.page.evaluate("colors => { window.colors = colors; }", COLORS)
    sight.until(lambda: settled(sight.page.evaluate("window.places.slice(-8)")))
    sight.page.evaluate("() => { window.places = []; }")
    sight.until(lambda: int(sight.page.evaluate("window.places.length")) >= FRAMES)
    at = middles(sight.page.evaluate("() => { window.colors = {}; return window.places.splice(0); }"))
    sight.picture(f"one_step_{mode.split()[-1].lower()}")
    for name in ("cloud", "line"):
        off = spread(at[name] - at["car"])
        assert not (off > TOLERANCE).any(), f"{name} in {(off > TOLERANCE).sum()} of {len(off)} pictures"
    assert mode != FREE or np.ptp(at["car"], axis=0).max() > 20.0, "both steps were seen"
