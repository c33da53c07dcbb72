"""The rules of `firstlap check` for what drives now."""

from __future__ import annotations

from html import escape

import viser

from firstlap.car_file import Car
from firstlap.rules import Rule, check_rules
from firstlap.setup_file import Setup
from firstlap.view.desk import assign

BROKEN, HOLDS = "#c92a2a", "#2b8a3e"
SMALL = "font-size:0.8em;line-height:1.35;padding:0 0.8em 0.5em"


class RulesShown:
    """In the container that is open."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")

    def update(self, setup: Setup, car: Car) -> None:
        """Called when the setup has changed."""
        content = rules_html(check_rules(setup, car))
        assign(self._html, "content", content)


def rules_html(rules: list[Rule]) -> str:
    """Broken ones first and with their advice."""
    if not rules:
        return f'<div style="{SMALL}">no rules of thumb for this driver</div>'
    broken = [rule for rule in rules if not rule.holds]
    kept = [rule for rule in rules if rule.holds]
    head = f"{len(broken)} of {len(rules)} rules broken" if broken else f"all {len(rules)} rules hold"
    colour = BROKEN if broken else HOLDS
    lines = [f'<b style="color:{colour}">{head}</b>', *map(_line, broken), *map(_line, kept)]
    return f'<div class="firstlap-rules" style="{SMALL}">' + "<br>".join(lines) + "</div>"


def _line(rule: Rule) -> str:
    mark, colour = ("✓", HOLDS) if rule.holds else ("✗", BROKEN)
    text = " ".join(f"{mark} {rule.name}: {rule.value:.2f} {rule.unit} ({rule.wanted})".split())
    advice = f'<br><span style="padding-left:1.2em">{escape(rule.remark)}</span>' if not rule.holds else ""
    return f'<span style="color:{colour}" title="{escape(rule.formula)}">{escape(text)}{advice}</span>'
