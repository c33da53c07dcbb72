"""The status line and the color legend."""

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
"""Number of color stops of the gradient."""


class StatusLine:
    """The status line, at the top of a gui."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html(waiting(), order=-100.0)

    def show(self, frame: Frame, setup: str, rate: float, top: float) -> None:
        """setup: title of the setup. rate: frames per second. top [m/s]: upper end of the speed color scale."""
        scale = scale_of(top) if len(planned_speeds(frame)) else ""
        self._html.content = (
            f'{status_of(frame, setup, rate)}<div style="{_SMALL}">{scale}{legend_of(frame.driver)}</div>'
        )


def waiting() -> str:
    """HTML before the first frame."""
    return f'<div style="padding:.5em .75em;color:{FAINT}">waiting for the first scan</div>'


def status_of(frame: Frame, setup: str, rate: float) -> str:
    """HTML: speed, status of the step, driver and setup, and the frame's message."""
    speed, _, status = commanded(frame)
    good = frame.may_drive and status in ("ok", "")
    label = status.replace("_", " ") or "no step yet"
    word = html.escape(label if frame.may_drive else "stopped")
    badge = f'<span style="{_BADGE};background:{GOOD if good else BAD}">{word}</span>'
    driven = f"{round(frame.speed, 1) + 0.0:.1f}"
    wanted = f"{speed:.1f}" if math.isfinite(speed) else "–"
    driver = [] if setup.startswith("driver ") else [f"driver {html.escape(frame.driver)}"]
    facts = [*driver, html.escape(setup), f"{rate:.0f} frames per second" if rate >= 0.5 else "paused"]
    where = [f"{frame.time:.1f} s"]
    where += [f"{frame.distance:.1f} m from the line"] if frame.distance is not None else []
    where += [f"{frame.offset:+.2f} m left of the centerline"] if frame.offset is not None else []
    color = "inherit" if frame.may_drive else BAD
    # The line also takes up space without a message, so that the controls below do not move.
    message = html.escape(frame.message)
    line = f'<div style="color:{color};{_MESSAGE}" title="{message}">{message}</div>'
    return (
        '<div style="padding:.5em .75em 0;line-height:1.45">'
        '<div style="display:flex;align-items:center;justify-content:space-between">'
        f'<span style="font-variant-numeric:tabular-nums"><b style="font-size:1.9em">{driven}</b> m/s '
        f'<span style="opacity:.65">of {wanted}</span></span>{badge}</div>'
        '<div style="font-size:.8em;opacity:.8;font-variant-numeric:tabular-nums">'
        f"{' · '.join(facts)}<br>{' · '.join(where)}</div>"
        f"{line}</div>"
    )


def scale_of(top: float) -> str:
    """HTML: the color scale of planned speeds from 0 to `top` [m/s]."""
    stops = ",".join(f"rgb({r},{g},{b})" for r, g, b in speed_colors(np.linspace(0.0, top, STOPS), top))
    marks = "".join(f"<span>{top * i / 4:g}</span>" for i in range(5))
    return (
        f'<div style="height:.6em;border-radius:.3em;background:linear-gradient(90deg,{stops})"></div>'
        f'<div style="display:flex;justify-content:space-between;opacity:.8">{marks}</div>'
        '<div style="opacity:.8">planned speed [m/s]</div>'
    )


def legend_of(driver: str) -> str:
    """HTML: the legend of the other colors in the scene."""
    legend = LEGENDS.get(driver, OTHER_LEGEND)
    return "".join(
        f'<span style="white-space:nowrap;margin-right:.8em"><span style="color:{color}">●</span> {name}</span> '
        for name, color in legend
    )


LEGENDS = {
    "local": (("left", LEFT), ("right", RIGHT), ("dropped", DROPPED), ("centerline", LINE), ("lookahead", PATH)),
    "global": (("return", RETURN), ("wall in the map", INK), ("racing line", LINE), ("plan", PATH)),
    "pid": (("return, left", RETURN), ("right", RIGHT), ("center", PATH)),
}
OTHER_LEGEND = (("return", RETURN), ("free", FREE), ("aim", PATH), ("nearest", BAD))
_SMALL = "padding:.5em .75em .4em;font-size:.75em;line-height:1.4"
_BADGE = "color:#fff;border-radius:.7em;padding:.1em .7em;font-weight:600;font-size:.9em"
_MESSAGE = "font-weight:600;height:1.45em;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
