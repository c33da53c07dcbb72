"""The line that says how it goes, and the scale of the colors."""

from __future__ import annotations

import html
import math

import numpy as np
import viser

from firstlap.pitwall.frame import Frame
from firstlap.pitwall.primitives import speed_colors
from firstlap.pitwall.scene import commanded, planned_speeds
from firstlap.plots.colors import BAD, DROPPED, FAINT, FREE, GOOD, INK, LEFT, LINE, PATH, RETURN, RIGHT

STOPS = 17
"""Of the gradient that stands for the colors of speeds."""


class StatusLine:
    """In a gui, above everything else."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html(waiting(), order=-100.0)

    def show(self, frame: Frame, setup: str, rate: float, top: float) -> None:
        """setup: its title. rate: frames shown per second. top [m/s]: where the colors of speeds end."""
        scale = scale_of(top) if len(planned_speeds(frame)) else ""
        self._html.content = (
            f'{status_of(frame, setup, rate)}<div style="{_SMALL}">{scale}{keys_of(frame.driver)}</div>'
        )


def waiting() -> str:
    """Before the first frame."""
    return f'<div style="padding:.5em .75em;color:{FAINT}">waiting for the first scan</div>'


def status_of(frame: Frame, setup: str, rate: float) -> str:
    """HTML: speed, status of the step, driver and setup, what the source says."""
    speed, _, status = commanded(frame)
    good = frame.going and status in ("ok", "")
    said = status.replace("_", " ") or "no step yet"
    word = html.escape(said if frame.going else "stopped")
    badge = f'<span style="{_BADGE};background:{GOOD if good else BAD}">{word}</span>'
    driven = f"{round(frame.speed, 1) + 0.0:.1f}"
    wanted = f"{speed:.1f}" if math.isfinite(speed) else "–"
    driver = [] if setup.startswith("driver ") else [f"driver {html.escape(frame.driver)}"]
    facts = [*driver, html.escape(setup), f"{rate:.0f} pictures a second" if rate >= 0.5 else "a standing picture"]
    where = [f"{frame.time:.1f} s"]
    where += [f"{frame.way:.1f} m of way"] if frame.way is not None else []
    where += [f"{frame.offset:+.2f} m off the middle"] if frame.offset is not None else []
    color = "inherit" if frame.going else BAD
    # Its place is kept where there is nothing to say: what stands below must not move under the mouse.
    said = html.escape(frame.said)
    words = f'<div style="color:{color};{_SAID}" title="{said}">{said}</div>'
    return (
        '<div style="padding:.5em .75em 0;line-height:1.45">'
        '<div style="display:flex;align-items:center;justify-content:space-between">'
        f'<span style="font-variant-numeric:tabular-nums"><b style="font-size:1.9em">{driven}</b> m/s '
        f'<span style="opacity:.65">of {wanted}</span></span>{badge}</div>'
        '<div style="font-size:.8em;opacity:.8;font-variant-numeric:tabular-nums">'
        f"{' · '.join(facts)}<br>{' · '.join(where)}</div>"
        f"{words}</div>"
    )


def scale_of(top: float) -> str:
    """HTML: the colors of planned speeds from 0 to `top` [m/s]."""
    stops = ",".join(f"rgb({r},{g},{b})" for r, g, b in speed_colors(np.linspace(0.0, top, STOPS), top))
    marks = "".join(f"<span>{top * i / 4:g}</span>" for i in range(5))
    return (
        f'<div style="height:.6em;border-radius:.3em;background:linear-gradient(90deg,{stops})"></div>'
        f'<div style="display:flex;justify-content:space-between;opacity:.8">{marks}</div>'
        '<div style="opacity:.8">planned speed [m/s]</div>'
    )


def keys_of(driver: str) -> str:
    """HTML: what the other colors of the scene say."""
    keys = KEYS.get(driver, OTHER_KEYS)
    return "".join(
        f'<span style="white-space:nowrap;margin-right:.8em"><span style="color:{color}">●</span> {name}</span> '
        for name, color in keys
    )


KEYS = {
    "local": (("left", LEFT), ("right", RIGHT), ("dropped", DROPPED), ("centerline", LINE), ("lookahead", PATH)),
    "global": (("return", RETURN), ("wall of its map", INK), ("its line", LINE), ("plan", PATH)),
    "pid": (("return, left", RETURN), ("right", RIGHT), ("the middle", PATH)),
}
OTHER_KEYS = (("return", RETURN), ("free", FREE), ("aim", PATH), ("near", BAD))
_SMALL = "padding:.5em .75em .4em;font-size:.75em;line-height:1.4"
_BADGE = "color:#fff;border-radius:.7em;padding:.1em .7em;font-weight:600;font-size:.9em"
_SAID = "font-weight:600;height:1.45em;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
