"""What a user sees and does in the browser."""

from __future__ import annotations

import io
import re
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image
from screens import SHOTS

from firstlap.pitwall.app import App, serve
from firstlap.pitwall.authentication import Authenticator
from firstlap.pitwall.panel import Panel, WatchPanel
from firstlap.pitwall.source import Source

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

COUNT = """
window.shown = 0;
window.drawn = 0;
const Plain = Worker;
window.Worker = class extends Plain {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({data}) => {
      if (data?.type !== "message_batch") return;
      const points = data.messages.some((m) => /PointCloud|SceneNodeUpdate/.test(m.type));
      if (points) window.shown += 1;
    });
  }
};
const tick = () => { window.drawn += 1; requestAnimationFrame(tick); };
requestAnimationFrame(tick);
window.done = 0;
for (const kind of ["pointerup", "keydown"]) addEventListener(kind, () => { window.done = Date.now(); }, true);
"""
"""Script that counts received batches of scene messages and rendered frames, and records the time [ms] of the last
input."""
PLACES = """
window.places = [];
window.colors = {};
let canvas = null;
for (const name of ["drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced"]) {
  const plain = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...given) {
    if (this.canvas.isConnected) canvas = this.canvas;
    return plain.apply(this, given);
  };
}
const copy = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
const look = (drawn) => {
  const [width, height] = [copy.canvas.width, copy.canvas.height] = [drawn.width, drawn.height];
  copy.drawImage(drawn, 0, 0);
  const {data} = copy.getImageData(0, 0, width, height);
  const place = {};
  for (const [name, [r, g, b]] of Object.entries(window.colors)) {
    let [x, y, count] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      if (Math.max(Math.abs(data[i] - r), Math.abs(data[i + 1] - g), Math.abs(data[i + 2] - b)) > 40) continue;
      x += (i / 4) % width;
      y += Math.floor(i / 4 / width);
      count += 1;
    }
    place[name] = count ? [x / count, y / count, count] : null;
  }
  window.places.push(place);
};
const later = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (callback) => later((time) => {
  canvas = null;
  callback(time);
  if (canvas && Object.keys(window.colors).length) look(canvas);
});
"""
"""Script that finds in each rendered frame the center [pixels] of each of `colors` and the number of its pixels."""
PATIENCE = 90.0


class Sight:
    """One browser page."""

    def __init__(
        self, browser: Browser, address: str, width: int = 1000, height: int = 800, fine: float = 0.15, script: str = ""
    ) -> None:
        self.context = browser.new_context(viewport={"width": width, "height": height})
        self.page: Page = self.context.new_page()
        self.page.add_init_script(COUNT)
        if script:
            self.page.add_init_script(script)
        self.page.set_default_timeout(1000.0 * PATIENCE)
        # A low resolution leaves CPU time to the race on machines without a graphics card.
        self.page.goto(f"{address}{'&' if '?' in address else '?'}fixedDpr={fine}")

    def ready(self) -> Sight:
        """Waits until the page shows a frame."""
        self.until(lambda: self.moment() is not None)
        return self

    def close(self) -> None:
        """Closes the page."""
        self.context.close()

    def until(self, condition: Callable[[], object], seconds: float = PATIENCE) -> None:
        """Waits for a condition. Raises AssertionError on a timeout."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "not seen"
            self.page.wait_for_timeout(60)

    def text(self) -> str:
        """All text of the page, including collapsed folders."""
        return str(self.page.evaluate("(document.getElementById('root') ?? document.body).textContent"))

    @property
    def connected(self) -> bool:
        """Whether the page, brought to the front, shows that it is connected."""
        self.page.bring_to_front()
        return (
            self.page.locator(".tabler-icon-cloud-check").count() > 0
            and not self.page.locator(".mantine-Loader-root").count()
        )

    def moment(self) -> float | None:
        """Time [s] in the status line."""
        found = re.search(r"frames per second(\d+\.\d) s", self.text())
        return float(found[1]) if found else None

    def press(self, label: str) -> None:
        """Clicks a button."""
        self.page.get_by_role("button", name=label, exact=True).first.click()

    def row(self, label: str) -> Locator:
        """The control with this label."""
        name = self.page.locator("label").filter(has_text=re.compile(rf"^(● )?{re.escape(label)}\b")).first
        name.scroll_into_view_if_needed()
        return self.page.locator(f'[id="{name.get_attribute("for")}"]')

    def box(self, label: str) -> Locator:
        """The number box of a slider."""
        return self.row(label).locator("xpath=..").locator("input[inputmode]").first

    def slide(self, label: str, share: float) -> None:
        """Drags a slider to a position from 0 to 1."""
        area = self.row(label).bounding_box()
        assert area is not None
        x, y = area["x"] + share * area["width"], area["y"] + 0.5 * area["height"]
        self.page.mouse.move(x + 12.0, y)
        self.page.mouse.down()
        self.page.mouse.move(x, y, steps=3)
        self.page.mouse.up()

    def picture(self, name: str) -> np.ndarray:
        """A screenshot (H, W, 3) of the whole page, which is also saved."""
        raw = self.page.screenshot(path=str(SHOTS / f"{name}.png"))
        return np.asarray(Image.open(io.BytesIO(raw)).convert("RGB"), dtype=int)

    def count(self, name: str) -> int:
        """A value recorded by COUNT."""
        return int(self.page.evaluate(f"window.{name}"))


def near(picture: np.ndarray, color: tuple[int, int, int], within: int = 40) -> int:
    """Number of pixels of a color."""
    return int((np.abs(picture - np.asarray(color)).max(axis=2) <= within).sum())


def wall(source: Source, token: str | None = None) -> tuple[Authenticator, App]:
    """A pit wall as made by `firstlap view`."""

    def panel(client: Any, may_control: bool, on_map: Any) -> Any:
        return Panel(client, source, on_map=on_map) if may_control else WatchPanel(client, source)

    authenticator = Authenticator(token)
    return authenticator, serve(source, port=0, authenticator=authenticator, panel=panel)
