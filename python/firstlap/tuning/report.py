"""The report of a tuning: one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from firstlap.common.version import __version__
from firstlap.config.parameters import Field
from firstlap.config.setup_file import Setup
from firstlap.evaluation.setup_limits import check_limits
from firstlap.sim.race import RaceResult, race
from firstlap.tuning.plots import (
    MOTION,
    draw_front,
    draw_importance,
    draw_laps,
    draw_lines,
    draw_parameters,
    draw_search,
    embedded,
)
from firstlap.tuning.run import Tuned
from firstlap.tuning.settings import Setting, settings_of
from firstlap.tuning.validate import Validation
from firstlap.tuning.variation import EVALUATION_FIELDS

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #22272e; max-width: 1100px; margin: 2em auto; padding: 0 1em; }
img { max-width: 100%; } h2 { margin-top: 2em; } .bad { color: #c62828; } .good { color: #2e7d32; }
table { border-collapse: collapse; margin: 1em 0; } th { text-align: left; border-bottom: 2px solid #9aa4af; }
td, th { padding: 0.2em 0.9em 0.2em 0; vertical-align: top; } td { border-bottom: 1px solid #eef1f4; }
.verdict { font-size: 1.15em; font-weight: 600; } code { background: #eef1f4; padding: 0 0.25em; }
"""


ROLES = (("holds", "fastest reliable"), ("seen", "fastest seen"))
"""Titles of the two selected setups."""


def page(title: str, parts: Iterable[str]) -> str:
    """A whole HTML page."""
    body = "\n".join(parts)
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return (
        f'<!doctype html>\n<html lang="en"><head>{head}</head><body><h1>{escape(title)}</h1>\n{body}\n</body></html>\n'
    )


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """An HTML table; cells are text."""
    lines = ["<table><tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{_cell(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    return "\n".join([*lines, "</table>"])


def _cell(cell: object) -> str:
    if isinstance(cell, bool):
        return '<span class="good">ok</span>' if cell else '<span class="bad">warning</span>'
    return escape("" if cell is None else str(cell))


def number(value: float | None, digits: int = 2) -> str:
    """A number with that many digits; a dash for None."""
    return "-" if value is None or value != value or abs(value) == float("inf") else f"{value:.{digits}f}"


def report(tuned: Tuned, found: dict[str, Any], validation: Validation | None, command: str) -> str:
    """The report as HTML. found: the summary as in --json."""
    settings = settings_of(tuned)
    parts = [
        _headline(found),
        f"<p>{escape(_what(tuned, found))}</p><p><code>{escape(command)}</code></p>",
        *(_validation(validation) if validation else []),
        "<h2>Lap by setting</h2>",
        embedded(draw_laps(settings), "lap time by setting"),
        *_parameters(tuned, settings),
        *_lines(tuned),
        "<h2>Lap time against clearance</h2>",
        embedded(
            draw_front(tuned.study.ordered, _marked(tuned), tuned.problem.margin),
            "lap against clearance of every trial",
        ),
        embedded(draw_search(tuned.study.ordered), "lap of every trial"),
        _tried(tuned),
        *_importance(tuned),
        *_rules(tuned),
        "<h2>How candidates were evaluated</h2>",
        table(
            ["name", "value", "", "what"],
            [(row.name, f"{tuned.session.judge[row.name]:g}", row.unit, row.doc) for row in EVALUATION_FIELDS.fields],
        ),
    ]
    return page(f"firstlap tune: {found['track']}", parts)


def _headline(found: dict[str, Any]) -> str:
    start = found["compared_with"]
    entries = [(start["setup"], {**start, "less": None, "file": ""})]
    entries += [(title, found[role]) for role, title in ROLES if found[role]]
    rows: list[Sequence[object]] = []
    for title, entry in entries:
        less = "" if entry["less"] is None else f"{100 * entry['less']:.1f} %"
        failed = f"{entry['failed']} of {entry['races']}"
        rows.append((title, number(entry["lap"]), less, failed, number(entry["clearance"]), entry["file"]))
    head = [
        "setup",
        "lap [s]",
        f"less than {start['setup']}",
        "failed on check seeds",
        "smallest clearance [m]",
        "file",
    ]
    missing = "" if found["holds"] else '<p class="verdict bad">No reliable setup was found.</p>'
    return missing + table(head, rows)


def _what(tuned: Tuned, found: dict[str, Any]) -> str:
    return (
        f"Driver {found['driver']}, car {found['car']}, {found['direction']}; {found['trials']} trials of up to "
        f"{found['seeds']} races, seed {found['seed']}; {found['laps']:.0f} laps simulated in {found['seconds']:.0f} s "
        f"of search, {found['laps_per_second']:.1f} per second with {found['workers']} workers; "
        f"study {found['study']} in {found['study_file']}; version {__version__}."
    )


def _validation(validation: Validation) -> list[str]:
    color = "bad" if validation.over_tuned else "good"
    rows = []
    for place in validation.places:
        mine, theirs = place.tuned, place.compared
        rows.append(
            (
                place.name,
                f"{mine.raced - mine.failed} of {mine.raced}",
                number(mine.lap),
                number(mine.clearance),
                f"{theirs.raced - theirs.failed} of {theirs.raced}",
                number(theirs.lap),
                "" if not place.worse else "fails more",
            )
        )
    head = ["where", "finished", "lap [s]", "clearance [m]"]
    return [
        "<h2>Validation</h2>",
        f'<p class="verdict {color}">{escape(validation.verdict)}</p>',
        table([*head, f"{validation.compared} finished", f"{validation.compared} lap [s]", ""], rows),
    ]


def _parameters(tuned: Tuned, settings: Sequence[Setting]) -> list[str]:
    fields = [axis.field for axis in tuned.session.space.axes]
    steering = [field for field in fields if field.section not in MOTION]
    motion = [field for field in fields if field.section in MOTION]
    parts = []
    for title, some in (("Steering parameters by setting", steering), ("Motion parameters by setting", motion)):
        if some:
            parts += [f"<h2>{title}</h2>", embedded(draw_parameters(some, settings), title.lower())]
    return [*parts, _values(fields, settings)]


def _values(fields: Sequence[Field], settings: Sequence[Setting]) -> str:
    rows = []
    for field in fields:
        values = [setting.given.get((field.section, field.name), field.default) for setting in settings]
        rows.append((field.key, *(f"{value:g}" for value in values), field.doc))
    return table(["parameter", *(setting.label for setting in settings), "what"], rows)


def _lines(tuned: Tuned) -> list[str]:
    """Races with one seed, under nominal conditions."""
    if tuned.choice.holds is None:
        return []
    compared, holds = _drive(tuned, tuned.search.compared), _drive(tuned, _setup(tuned, "holds"))
    words = f"A flying lap without spread: {compared.setup.name} dashed, the reliable setup colored by its speed."
    return [
        "<h2>Driven lines</h2>",
        f"<p>{escape(words)}</p>",
        embedded(draw_lines(tuned.session.track, compared, holds), "driven lines"),
    ]


def _setup(tuned: Tuned, role: str) -> Setup:
    chosen = tuned.choice.holds if role == "holds" else tuned.choice.seen
    assert chosen is not None
    return Setup(role, chosen.trial.given, driver=tuned.session.driver)


def _drive(tuned: Tuned, setup: Setup) -> RaceResult:
    return race(tuned.session.track, setup, tuned.session.car, laps=2, seed=1)


def _marked(tuned: Tuned) -> dict[str, tuple[float, float]]:
    choice = tuned.choice
    return {
        name: (chosen.lap, chosen.check.clearance)
        for name, chosen in (("fastest reliable", choice.holds), ("fastest seen", choice.seen))
        if chosen and chosen.check.lap and not (name == "fastest seen" and chosen == choice.holds)
    }


def _tried(tuned: Tuned) -> str:
    """The finalists on the check seeds."""
    rows = [
        (
            chosen.trial.start or f"trial {chosen.trial.number}",
            number(chosen.trial.verdict.lap),
            number(chosen.check.lap),
            f"{chosen.check.failed} of {chosen.check.raced}",
            number(chosen.check.clearance),
            "chosen" if chosen == tuned.choice.holds else "holds" if chosen.check.holds else "not reliable",
        )
        for chosen in tuned.choice.tried
    ]
    head = ["raced again", "lap in the search [s]", "lap on fresh seeds [s]", "failed", "smallest clearance [m]", ""]
    return table(head, rows)


def _importance(tuned: Tuned) -> list[str]:
    shares = tuned.study.parameters_that_mattered()
    if not shares:
        return []
    words = "By PED-ANOVA: which parameters separate the best tenth of the trials from the rest."
    return ["<h2>Which parameters mattered</h2>", f"<p>{words}</p>", embedded(draw_importance(shares), "importance")]


def _rules(tuned: Tuned) -> list[str]:
    """`firstlap check` of the starting and the selected setups, side by side."""
    columns = [(tuned.search.compared.name, tuned.search.compared)]
    columns += [(role, _setup(tuned, role)) for role in ("holds", "seen") if getattr(tuned.choice, role)]
    rows: list[Sequence[object]] = []
    for name, setup in columns:
        for rule in check_limits(setup, tuned.session.car):
            words = f"{rule.value:.2f} {rule.unit}".rstrip()
            rows.append((name, rule.name, rule.formula, words, rule.wanted, rule.holds, rule.remark))
    if not rows:
        return []
    return [
        "<h2>Rules of thumb</h2>",
        "<p>From <code>firstlap check</code>: the selected setups compared with the rules of thumb.</p>",
        table(["setup", "rule", "formula", "value", "wanted", "", "remark"], rows),
    ]
