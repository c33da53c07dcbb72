"""The report of `firstlap paper`: Markdown, HTML, the numbers as JSON, and every figure as a file.

The same seeds give the same bytes: it holds no dates, no compute times and no names of machines.
"""

from __future__ import annotations

import io
import json
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from firstlap.common.files import write_together
from firstlap.common.text import short_name
from firstlap.common.version import __version__
from firstlap.config.car_file import Car
from firstlap.config.parameters import Value
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.compare.compare import Comparison
from firstlap.evaluation.compare.plot import comparison_figure
from firstlap.evaluation.compare.report import number, order_lines
from firstlap.evaluation.perception.ground_truth import GroundTruth
from firstlap.evaluation.published import CHANGES, FIRST, LAPS_BY_GROUP, LAST, NOT_ROBUST, PUBLISHED, SETTING_LAPS
from firstlap.explain.local import draw_local
from firstlap.explain.snapshot import explain_race
from firstlap.paper.figures import draw_architecture, draw_comparison, draw_distances, draw_driven_lines, draw_layout
from firstlap.paper.scenes import Lap, draw_errors, draw_middle, draw_sections, draw_width
from firstlap.paper.settings import MOTION, STEERING, SettingResult, paper_summary
from firstlap.paper.settings_report import EXPLANATION, HEADINGS, plotted, setting_rows, silent_rows
from firstlap.tracks.track import Track
from firstlap.tuning.plots import draw_laps, draw_parameters
from firstlap.tuning.report import page

DPI = 90
"""Of the figures."""
NAME = "report"
"""Of the report's files, without suffix."""
SEED = 1
"""Of the lap from which the single steps are."""


@dataclass(frozen=True)
class PaperRun:
    """Everything that was driven on one track (in the direction of travel). lap: None if its car did not get round."""

    track: Track
    car: Car
    reverse: bool
    seeds: int
    lap: Lap | None
    driven: Sequence[SettingResult]
    published_only: Sequence[SettingResult]
    comparison: Comparison

    @property
    def name(self) -> str:
        """The track's name for titles."""
        return short_name(self.track.name) + (", reverse" if self.reverse else "")


@dataclass(frozen=True)
class Section:
    """A part of the report: text, then tables (heading and rows), then figures by file name."""

    title: str
    text: str = ""
    table: tuple[Sequence[str], Sequence[Sequence[str]]] | None = None
    figures: tuple[str, ...] = ()


def summary(run: PaperRun) -> dict[str, Any]:
    """The numbers of the report, without compute times."""
    compared = run.comparison.to_dict()
    for row in compared["entries"]:
        for name in [key for key in row if key.startswith("compute_") or key == "preparation"]:
            del row[name]
    return {
        "version": __version__,
        "track": run.name,
        "seeds": run.seeds,
        "settings": paper_summary(run.name, run.track, run.car, run.driven),
        "published_only": paper_summary(run.name, run.track, run.car, run.published_only),
        "comparison": compared,
    }


def write_paper_report(run: PaperRun, folder: Path, done: Callable[[], object]) -> list[Path]:
    """Writes report.md, report.html, report.json and the figures; returns the files. Raises InputError.

    done: called after each figure.
    """
    found = summary(run)
    figures = {}
    for name, draw in _figures(run, found).items():
        figures[name] = _png(draw())
        done()
    sections = [section for section in _sections(run, found) if set(section.figures) <= set(figures)]
    title = f"The paper's results on {run.name}"
    body = _markdown(sections)
    files = {folder / name: content for name, content in figures.items()}
    files[folder / f"{NAME}.md"] = f"# {title}\n\n{body}".encode()
    files[folder / f"{NAME}.html"] = page(title, [_html(body)]).encode()
    files[folder / f"{NAME}.json"] = (json.dumps(found, indent=1, allow_nan=False) + "\n").encode()
    write_together(files)
    return list(files)


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    return buffer.getvalue()


def _figures(run: PaperRun, found: dict[str, Any]) -> dict[str, Callable[[], Figure]]:
    settings, fields = plotted(run.driven), run.driven[0].setup.fields
    steering, motion = ([fields.find(name, "paper") for name in names] for names in (STEERING, MOTION))
    printed = printed_values()
    return {
        "architecture.png": draw_architecture,
        **_lap_figures(run),
        "layout.png": lambda: draw_layout(run.track),
        "steering.png": lambda: draw_parameters(steering, settings, printed),
        "motion.png": lambda: draw_parameters(motion, settings, printed),
        "laps.png": lambda: draw_laps(settings, SETTING_LAPS),
        "lines.png": lambda: draw_driven_lines(run.track, run.driven),
        "distances.png": lambda: draw_distances(run.driven),
        "comparison.png": lambda: draw_comparison(found["comparison"]),
        "comparison_lines.png": lambda: comparison_figure(run.comparison),
    }


def _lap_figures(run: PaperRun) -> dict[str, Callable[[], Figure]]:
    lap = run.lap
    if lap is None:
        return {}
    truth = GroundTruth.of(run.track)
    at = run.track.length + lap.middle.at
    return {
        "sections.png": lambda: draw_sections(lap.sections, truth),
        "width.png": lambda: draw_width(lap.width, truth),
        "centerline.png": lambda: draw_middle(lap.middle, truth),
        "errors.png": lambda: draw_errors(lap),
        "step.png": lambda: draw_local(
            explain_race(run.track, load_setup(FIRST), run.car, at, seed=SEED, reverse=False)
        ),
    }


def printed_values() -> dict[str, dict[int, Value]]:
    """{parameter: {setting: value}} that the paper prints."""
    first, last = load_setup(FIRST), load_setup(LAST)
    ends = {name: {0: first.get(name), 5: last.get(name)} for name in PUBLISHED}
    for place, changes in CHANGES.items():
        for name, value in changes.items():
            ends[name][place] = value
    return ends


def _sections(run: PaperRun, found: dict[str, Any]) -> list[Section]:
    return [_head(run), *_method_sections(run), *_setting_sections(run, found), *_comparison_sections(run, found)]


def _head(run: PaperRun) -> Section:
    text = (
        'M. Fazekas, Z. Demeter, J. Tóth, Á. Bogár-Németh, G. Bári, "Evaluation of Local Planner-Based Stanley Control '
        'in Autonomous RC Car Racing Series", IEEE IV 2024 ([arXiv 2408.15152](https://arxiv.org/abs/2408.15152)): its '
        f"figures and numbers, simulated on {run.name} ({run.track.length:.1f} m, car {run.car.name}, firstlap "
        f"{__version__}). The paper's laps are of its own track.\n\n```sh\n{_command(run)}\n```"
    )
    return Section("", text)


def _command(run: PaperRun) -> str:
    """The command line that writes this report."""
    drivers = ",".join(entry.label for entry in run.comparison.entries)
    words = ["firstlap", "paper", short_name(run.track.name), "-o", "FOLDER", "--seeds", str(run.seeds)]
    words += ["--drivers", drivers, "--car", run.car.name, *(["--reverse"] if run.reverse else [])]
    return shlex.join(words)


def _method_sections(run: PaperRun) -> list[Section]:
    lap = "" if run.lap else f" The car did not get round with setup {FIRST}: figures of single steps are missing."
    return [
        Section("Architecture", "The paper's block diagram (its Figure 1)." + lap, figures=("architecture.png",)),
        Section("Segmented scan", "The step of a lap with the most sections of wall.", figures=("sections.png",)),
        Section("Track width", "The step with the largest change of width within one scan.", figures=("width.png",)),
        Section(
            "Centerline",
            "The step in which the mean of both sides is farthest from the centerline: part of a side is hidden.",
            figures=("centerline.png",),
        ),
        Section(
            "Stanley errors",
            f"Over a flying lap with setup {FIRST}, and the four terms in the step of the figure above.",
            figures=("errors.png", "step.png"),
        ),
        Section("Track layout", figures=("layout.png",)),
    ]


def _setting_sections(run: PaperRun, found: dict[str, Any]) -> list[Section]:
    alone = setting_rows(found["published_only"])
    return [
        Section("The settings", EXPLANATION, (HEADINGS, setting_rows(found["settings"]))),
        Section("Steering parameters by setting", "Figure 8. Squares: printed values.", figures=("steering.png",)),
        Section("Motion parameters by setting", "Figure 9. Squares: printed values.", figures=("motion.png",)),
        Section("Lap time by setting", "Figure 10. Crosses: not every race finished.", figures=("laps.png",)),
        Section(
            "Published parameters alone",
            "The same with everything fixed that the paper does not print, also the cornering limit.",
            (HEADINGS, alone),
        ),
        Section("Driven lines and distance", figures=("lines.png", "distances.png")),
        Section(
            "What the paper does not print",
            "Values over the settings; one where all have the same.",
            (("parameter", "value", "unit", "meaning"), silent_rows(found["settings"], run.driven)),
        ),
    ]


def _comparison_sections(run: PaperRun, found: dict[str, Any]) -> list[Section]:
    compared = found["comparison"]
    rows = [
        [
            row["label"],
            row["tuned_for"] or "untuned",
            f"{row['finished']} of {row['runs']}",
            number(row["median"]),
            *(_gap(row["median"], lap) for lap in _reference_laps(compared)),
        ]
        for row in compared["entries"]
    ]
    paper = [
        [f"the paper: {group}", "", "", f"{lap:g}", *(_gap(lap, other) for other in _paper_reference_laps())]
        for group, lap in (*LAPS_BY_GROUP.items(), ("local, not robust", SETTING_LAPS[NOT_ROBUST]))
    ]
    text = (
        f"Section V-B: {run.comparison.laps} laps, seeds 1 to {run.seeds}, without latency. Gaps are to the lap of the "
        "paper's setting (the paper: 12.8 s) and to that of the driver with a map (the paper: the winner)."
    ).replace("12.8", f"{LAPS_BY_GROUP['local']:g}")
    head = ("driver", "tuned for", "finished", "lap [s]", "gap to the paper's setting", "gap to global")
    lines = "\n".join(f"- {line}." for line in order_lines(compared))
    return [
        Section("Comparison", text, (head, [*paper, *rows])),
        Section("Gaps", lines, figures=("comparison.png", "comparison_lines.png")),
    ]


def _reference_laps(compared: dict[str, Any]) -> list[float | None]:
    laps = compared["published"]["laps"]
    return [laps[group]["median"] if group in laps else None for group in ("local", "global")]


def _paper_reference_laps() -> list[float]:
    return [LAPS_BY_GROUP["local"], LAPS_BY_GROUP["global"]]


def _gap(lap: float | None, other: float | None) -> str:
    return "–" if lap is None or other is None else f"{100 * (lap / other - 1):+.1f} %"


def _markdown(sections: Sequence[Section]) -> str:
    parts = []
    for section in sections:
        parts += [f"## {section.title}"] if section.title else []
        parts += [section.text] if section.text else []
        if section.table:
            head, rows = section.table
            parts.append("\n".join([_row(head), "|" + "---|" * len(head), *map(_row, rows)]))
        parts += [f"![{section.title.lower()}]({name})" for name in section.figures]
    return "\n\n".join(parts) + "\n"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _html(markdown: str) -> str:
    from markdown_it import MarkdownIt

    return str(MarkdownIt("commonmark").enable("table").render(markdown))
