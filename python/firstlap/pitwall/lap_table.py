"""The lap table."""

from __future__ import annotations

import html

import viser

from firstlap.pitwall import lap_setup
from firstlap.pitwall.frame import DrivenLap, Frame
from firstlap.pitwall.map_shapes import best_of
from firstlap.plots.colors import GOOD

ROWS = 8
"""Number of listed laps, newest first; the best one is always listed."""
COLUMNS = ("lap", "s", "to best", "m/s", "clearance m", "setup")
START_TIME = 1.0
"""[s] A first frame before this time of the source's clock counts as the start of the lap."""


class LapTable:
    """The lap table in a gui."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html(table_of((), None))
        self._seen: int | None = None
        self._time = 0.0
        self._began: float | None = None

    def show(self, frame: Frame) -> None:
        """Shows the frame's complete laps and its current one."""
        self._follow(frame)
        self._html.content = table_of(frame.laps, self._running(frame))

    def _follow(self, frame: Frame) -> None:
        """Notes when the current lap began."""
        number = frame.laps[-1].number if frame.laps else 0
        if self._seen is None or number != self._seen or frame.time < self._time:
            fresh = self._seen is None or frame.time < self._time
            self._began = None if fresh and frame.time > START_TIME else frame.time
        self._seen, self._time = number, frame.time

    def _running(self, frame: Frame) -> float | None:
        """Time [s] of the current lap; None if its start was not observed."""
        began = self._began if frame.lap_start is None else frame.lap_start
        return None if began is None or not frame.may_drive else frame.time - began


def table_of(laps: tuple[DrivenLap, ...], running: float | None) -> str:
    """HTML: number, time, difference to the best, mean speed, clearance and setup of each lap, with the best one marked
    and the current lap on top.

    laps: oldest first. running: time of the current lap [s], or None.
    """
    best = best_of(laps)
    listed = list(reversed(laps[-ROWS:]))
    if best and best not in listed:
        listed = [*listed[:-1], best]
    rows = [_row(lap, best) for lap in listed]
    number = laps[-1].number + 1 if laps else 1
    now = f"{running:.1f}" if running is not None else "–"
    rows.insert(0, f'<tr style="opacity:.65">{_cells(str(number), now, "running", "", "", "")}</tr>')
    head = "".join(f'<th style="{_RIGHT};font-weight:600">{name}</th>' for name in COLUMNS)
    return (
        '<div style="padding:.25em .75em"><table style="width:100%;border-collapse:collapse;font-size:.8em;'
        f'line-height:1.5;font-variant-numeric:tabular-nums"><thead><tr style="opacity:.65">{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


_RIGHT = "text-align:right;padding:0 .4em"
_SHORTENED = f"{_RIGHT};max-width:7em;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"


def _row(lap: DrivenLap, best: DrivenLap | None) -> str:
    behind = "best" if lap is best else f"{lap.time - best.time:+.3f}" if best else ""
    number = f"{lap.number}" + (" ⚑" if lap.standing else "")
    mean = f"{float(lap.speed.mean()):.2f}" if len(lap.speed) else "–"
    clearance = "–" if lap.clearance is None else f"{lap.clearance:.2f}"
    style = f"color:{GOOD};font-weight:700" if lap is best else ""
    details = "; ".join(text for text in ("standing start" if lap.standing else "", lap_setup.long(lap)) if text)
    title = f' title="{html.escape(details)}"' if details else ""
    cells = _cells(number, f"{lap.time:.3f}", behind, mean, clearance, lap_setup.short(lap))
    return f'<tr style="{style}"{title}>{cells}</tr>'


def _cells(*texts: str) -> str:
    styles = [*[_RIGHT] * (len(texts) - 1), _SHORTENED]  # the setup's name may be long
    return "".join(f'<td style="{style}">{html.escape(text)}</td>' for style, text in zip(styles, texts, strict=True))
