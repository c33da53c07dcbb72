"""The limits of `firstlap check` for the current setup."""

from __future__ import annotations

from html import escape

import viser

from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.evaluation.setup_limits import LimitCheck, check_limits
from firstlap.pitwall.viewer_session import assign
from firstlap.plots.colors import BAD, GOOD

ALLOWED = "every value is allowed; these are the rules of thumb of firstlap check"
SMALL = "font-size:0.8em;line-height:1.35;padding:0 0.8em 0.5em"


class LimitsPanel:
    """Built in the current gui container."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")

    def update(self, setup: Setup, car: Car) -> None:
        """Shows the limits of a changed setup."""
        content = rules_html(check_limits(setup, car))
        assign(self._html, "content", content)


def rules_html(rules: list[LimitCheck]) -> str:
    """HTML of the checks, violated ones first. Its height is constant, so that controls below it do not move."""
    if not rules:
        return f'<div style="{SMALL}">no rules of thumb for this driver</div>'
    broken = [rule for rule in rules if not rule.holds]
    kept = [rule for rule in rules if rule.holds]
    head = f"{len(broken)} warning{'s' * (len(broken) > 1)}" if broken else "all limits kept"
    advice = "; ".join(f"{rule.name}: {rule.remark}" for rule in broken)
    title = _line(f"<b>{head}</b>, of {len(rules)} rules of thumb", not broken, ALLOWED)
    lines = [title, *map(_rule, broken), *map(_rule, kept)]
    below = f'<div style="height:2.7em;overflow:hidden;color:{BAD}" title="{escape(advice)}">{escape(advice)}</div>'
    return f'<div class="firstlap-rules" style="{SMALL}">{"".join(lines)}{below}</div>'


def _rule(rule: LimitCheck) -> str:
    mark = "✓" if rule.holds else "✗"
    text = " ".join(f"{mark} {rule.name}: {rule.value:.2f} {rule.unit} ({rule.wanted})".split())
    return _line(escape(text), rule.holds, f"{rule.formula}; {rule.remark}")


def _line(html: str, good: bool, hint: str = "") -> str:
    style = f"color:{GOOD if good else BAD};white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
    return f'<div style="{style}" title="{escape(hint)}">{html}</div>'
