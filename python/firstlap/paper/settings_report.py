"""The report of `firstlap tune --paper`: one HTML file with the paper's Figures 8 to 10."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from firstlap.evaluation.published import SETTING_LAPS
from firstlap.paper.settings import MOTION, STEERING, SettingResult, silent_fields, values_text
from firstlap.tuning.plots import draw_laps, draw_parameters, embedded
from firstlap.tuning.report import number, page, table
from firstlap.tuning.settings import Setting

HEADINGS = ("setting", "lap [s]", "less than 0", "finished", "finished with spread", "paper's lap [s]", "less than 0")
EXPLANATION = (
    "The paper prints settings 0 and 5 completely and the changes of 2 and 4; 1 and 3 are the means of their "
    "neighbors. Setting 6 is the one that the paper calls faster but not robust; it prints only its lap. Its laps are "
    "of its own track. Finished with spread: grip, delays, mass, servo and start at the limits of their spread."
)


def plotted(driven: Sequence[SettingResult]) -> list[Setting]:
    """The settings for the plots of `tuning.plots`."""
    return [
        Setting(str(place), one.setup.given, one.lap, one.varied_finished == len(one.varied) and one.failed == 0)
        for place, one in enumerate(driven)
    ]


def setting_rows(found: Mapping[str, Any]) -> list[list[str]]:
    """The rows of the table as text, in the order of `HEADINGS`."""
    return [
        [
            str(row["setting"]),
            number(row["lap"]),
            percent(row["less"]),
            f"{row['races'] - row['failed']} of {row['races']}",
            f"{row['varied_finished']} of {row['varied_races']}",
            number(row["paper_lap"], 1),
            percent(row["paper_less"]),
        ]
        for row in found["settings"]
    ]


def silent_rows(found: Mapping[str, Any], driven: Sequence[SettingResult]) -> list[list[str]]:
    """Every parameter that the paper does not print: name, values, unit, meaning."""
    return [
        [row.key, values_text(found["silent"][row.key]), row.unit, row.doc] for row in silent_fields(driven[0].setup)
    ]


def percent(share: float | None) -> str:
    """A share in per cent; a dash for None."""
    return "-" if share is None else f"{100 * share:.0f} %"


def settings_page(found: Mapping[str, Any], driven: Sequence[SettingResult]) -> str:
    """The report as HTML."""
    settings, fields = plotted(driven), driven[0].setup.fields
    words = f"{found['track']}, {found['track_length']:.1f} m, car {found['car']}, version {found['version']}. "
    return page(
        f"The paper's settings on {found['track']}",
        [
            f"<p>{words}{EXPLANATION}</p>",
            table(HEADINGS, setting_rows(found)),
            "<h2>Steering parameters by setting</h2>",
            embedded(draw_parameters([fields.find(name, "paper") for name in STEERING], settings), "steering"),
            "<h2>Motion parameters by setting</h2>",
            embedded(draw_parameters([fields.find(name, "paper") for name in MOTION], settings), "motion"),
            "<h2>Lap time by setting</h2>",
            embedded(draw_laps(settings, SETTING_LAPS), "lap time"),
            "<h2>What the paper does not print</h2>",
            table(("parameter", "value", "unit", "meaning"), silent_rows(found, driven)),
        ],
    )
