"""`firstlap paper`: everything that the paper reports, from one command."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.published import CHANGES, LAPS_BY_GROUP, SETTING_LAPS
from firstlap.paper.comparison import compared_drivers
from firstlap.paper.report import printed_values
from firstlap.paper.scenes import drive_lap
from firstlap.tracks.library import load_track

QUICK = ("paper", "oval", "--seeds", 1, "--drivers", "local:race,gap,local:brisk")
FIGURES = {
    "architecture", "sections", "width", "centerline", "errors", "step", "layout", "steering", "motion", "laps",
    "lines", "distances", "comparison", "comparison_lines",
}  # fmt: skip


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Races of two laps."""
    monkeypatch.setattr("firstlap.paper.settings.LAPS", 2)
    monkeypatch.setattr("firstlap.paper.comparison.LAPS", 2)


@pytest.mark.usefixtures("short")
def test_it_writes_the_report_with_every_figure_and_the_same_seeds_give_the_same_bytes(cli):
    said = cli(*QUICK, "-o", "a", "--json")
    assert said.code == 0, said.err
    files = {path.name: path.read_bytes() for path in Path("a").iterdir()}
    assert set(files) == {"report.md", "report.html", "report.json"} | {f"{name}.png" for name in FIGURES}
    text = files["report.md"].decode()
    assert set(re.findall(r"!\[.*?\]\((\w+)\.png\)", text)) == FIGURES
    for number in (*SETTING_LAPS.values(), *LAPS_BY_GROUP.values()):
        assert f"{number:g}" in text
    for word in ("the paper's setting: reactive (gap, tuned for unknown tracks", "trajectory.smoothing_iterations"):
        assert word in text
    assert files["report.html"].decode().count("<img") == len(FIGURES)
    found = json.loads(files["report.json"])
    assert {key: said.json[key] for key in found} == found
    assert cli(*QUICK, "-o", "b").code == 0
    assert {path.name: path.read_bytes() for path in Path("b").iterdir()} == files


def test_the_printed_values_are_those_of_the_paper():
    printed = printed_values()
    assert printed["k_ang"] == {0: 0.6, 2: 0.3, 5: 0.3}
    assert printed["k_soft"][4] == CHANGES[4]["k_soft"]


def test_setups_tuned_for_the_track_are_compared_there_and_nowhere_else(arena):
    assert {"local:local_arena", "gap:gap_arena"} <= set(compared_drivers(arena).split(","))
    assert "arena" not in compared_drivers(load_track("oval"))


def test_the_single_steps_are_the_most_telling_of_a_flying_lap():
    track = load_track("width_step")
    lap = drive_lap(track, load_setup("sure"), load_car("default"), 1)
    assert lap is not None
    seen = lap.width.trace["line"]["width"][lap.width.trace["line"]["support"] == 3]
    assert seen.max() - seen.min() > 0.7
    assert lap.errors["s"].max() <= track.length
    assert all(len(column) == len(lap.errors["s"]) for column in lap.errors.values())


def test_an_interrupt_leaves_no_report(cli, monkeypatch):
    monkeypatch.setattr("firstlap.cli.paper.drive_with_progress", lambda *_: [])
    monkeypatch.setattr("firstlap.cli.paper.drive_comparison", lambda _: True)
    said = cli(*QUICK, "-o", "a")
    assert said.code == 130
    assert said.err.strip() == "error: interrupted"
    assert not list(Path("a").iterdir())


BAD = {
    "a recording": (("race.mcap", "-o", "a"), "is a recording, which cannot be raced; expected a track or a map"),
    "no such track": (("nowhere", "-o", "a"), "no such track or file"),
    "no folder": (("oval",), "-o"),
    "a file as the folder": (("oval", "-o", "file"), "--out file: cannot be written"),
    "unknown driver": (("oval", "-o", "a", "--drivers", "gobal"), "is not a driver"),
    "unknown car": (("oval", "-o", "a", "--car", "truck"), "no such car"),
}


@pytest.mark.parametrize(("arguments", "words"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line_and_exit_2(cli, arguments, words):
    Path("file").write_text("here")
    said = cli("paper", *arguments)
    assert said.code == 2
    assert re.fullmatch(r"error: .+\n", said.err)
    assert words in said.err
    assert said.out == ""
