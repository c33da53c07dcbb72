"""Comparisons: every race once, table, plot, and a report that makes the result reproducible."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from waiting import PATIENCE

import firstlap
from firstlap import _core
from firstlap.config.driver_kind import CoreHandle, TableParams
from firstlap.config.setup_file import list_setups, load_setup
from firstlap.drivers import DRIVERS, DriverKind, Preparation
from firstlap.evaluation.compare.compare import (
    Comparison,
    Entry,
    best_of_groups,
    group_gaps,
    parse_entries,
    published_of_groups,
    reference_row,
)
from firstlap.evaluation.compare.record import Store, race_key, to_record
from firstlap.evaluation.compare.report import order_lines

CAR = firstlap.load_car("default")
QUICK = ("compare", "oval", "--laps", 2, "--seeds", 2, "--store", "races", "--latency", "none")
MAP_LESS = "local,gap,disparity,pid"


def comparison(tmp_path: Path, drivers: str = "gap,pid", **options: Any) -> Comparison:
    """A small comparison, not yet driven."""
    settings: dict[str, Any] = {"laps": 2, "seeds": 2, "latency": "none", **options}
    track = firstlap.load_track("oval")
    return Comparison(track, parse_entries(drivers, CAR), CAR, store=Store(tmp_path / "races"), **settings)


def test_every_driver_races_every_seed_and_the_table_has_all_its_columns(cli):
    ran = cli(*QUICK, "--drivers", MAP_LESS, "--json")
    assert ran.code == 0, ran.err
    assert [row["label"] for row in ran.json["entries"]] == ["local", "gap", "disparity", "pid"]
    for row in ran.json["entries"]:
        assert (row["runs"], row["finished"], row["success_rate"]) == (2, 2, 1.0)
        assert row["best"] <= row["median"]
        assert row["mean_speed"] == pytest.approx(row["distance"] / row["median"], rel=0.02)
        assert 0.0 < row["compute_p50"] <= row["compute_p99"]
        assert row["min_clearance"] > 0.0
        assert row["needs_map"] is False
    fastest = min(ran.json["entries"], key=lambda row: row["median"])
    assert ran.json["reference"] == fastest["label"]
    assert fastest["relative"] == 1.0


def test_laps_are_those_of_the_races_that_race_drives(cli):
    row = cli(*QUICK, "--drivers", "gap", "--json").json["entries"][0]
    flying = [
        cli("race", "oval", "--driver", "gap", "--laps", 2, "--seed", s, "--json").json["laps"][1] for s in (1, 2)
    ]
    times = sorted(lap["time"] for lap in flying)
    assert row["best"] == times[0]
    assert row["median"] == pytest.approx(sum(times) / 2)
    assert row["spread"] == pytest.approx((times[1] - times[0]) / 2)


def test_a_driver_may_come_with_several_setups(cli):
    Path("brisk.yaml").write_text("driver: gap\nspeed:\n  v_max: 2.0\n")
    ran = cli(*QUICK, "--drivers", "gap,gap:brisk.yaml", "--json")
    rows = ran.json["entries"]
    assert [row["label"] for row in rows] == ["gap", "gap:brisk"]
    assert rows[1]["median"] > rows[0]["median"]


def test_a_second_call_races_nothing_again_and_a_changed_one_does(tmp_path, monkeypatch):
    first = comparison(tmp_path)
    first.drive()
    assert first.from_store == 0
    monkeypatch.setattr("firstlap.evaluation.compare.compare.race", lambda *_a, **_o: pytest.fail("raced again"))
    second = comparison(tmp_path)
    second.drive()
    assert second.from_store == 4
    assert second.to_dict() == first.to_dict()
    monkeypatch.undo()
    third = comparison(tmp_path, laps=1)
    third.drive()
    assert third.from_store == 0


def test_the_key_of_a_race_tells_everything_that_it_depends_on():
    track, setup = firstlap.load_track("oval"), firstlap.load_setup("gap")
    keys = {
        race_key(track, setup, CAR, 2, 1, "none", {}),
        race_key(track.reversed(), setup, CAR, 2, 1, "none", {}),
        race_key(track, setup.with_values({"v_max": 3.0}), CAR, 2, 1, "none", {}),
        race_key(track, firstlap.load_setup("pid"), CAR, 2, 1, "none", {}),
        race_key(track, setup, firstlap.load_car("gym"), 2, 1, "none", {}),
        race_key(track, setup, CAR, 3, 1, "none", {}),
        race_key(track, setup, CAR, 2, 2, "none", {}),
        race_key(track, setup, CAR, 2, 1, "measured", {}),
        race_key(track, setup, CAR, 2, 1, "none", {"mu_scale": 0.9}),
    }
    assert len(keys) == 9


def test_a_stored_race_is_the_race(tmp_path):
    record = to_record(firstlap.race(firstlap.load_track("oval"), driver="pid", laps=2))
    store = Store(tmp_path)
    store.save("a", record)
    loaded = store.load("a")
    assert loaded is not None
    assert (loaded.laps, loaded.outcome, loaded.distance) == (record.laps, record.outcome, record.distance)
    assert np.array_equal(loaded.path["x"], record.path["x"])
    line = loaded.line_of_best_lap()
    assert line is not None
    assert line["time"][-1] - line["time"][0] == pytest.approx(record.laps[1].time, abs=0.06)
    assert store.load("b") is None
    (tmp_path / "a.npz").write_bytes(b"half a file")
    assert store.load("a") is None


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_an_interrupted_comparison_goes_on_where_it_was(tmp_path):
    code = "from firstlap.cli import main; main()"
    arguments = ["compare", "arena", "--drivers", "gap,pid", "--seeds", "400", "--laps", "2", "--store", tmp_path]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )

    def kept() -> int:
        """The finished files of the store; hidden files are still being written."""
        return len([path for path in tmp_path.glob("*.npz") if not path.name.startswith(".")])

    deadline = time.monotonic() + PATIENCE
    while kept() < 3 and time.monotonic() < deadline:
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    driven = re.fullmatch(r"error: interrupted after (\d+) of 800 races; the same command resumes there\n", err)
    assert driven, err
    # A race that ends during the interrupt may be stored without being counted, but not vice versa.
    assert kept() >= int(driven[1]) >= 1


def test_reports_hold_what_is_needed_to_repeat_them(cli):
    ran = cli(*QUICK, "--drivers", "gap,pid", "--report", "a.md", "--plot", "a.svg", "--car", "nuc2")
    assert ran.code == 0, ran.err
    text = Path("a.md").read_text()
    assert "firstlap compare oval --drivers gap,pid --laps 2 --seeds 2 --car nuc2 --latency none" in text
    for word in (firstlap.__version__, "seeds 1 to 2", "| gap | 1 | finished |", "![", "friction: 1.0"):
        assert word in text
    assert Path("a.png").stat().st_size > 20_000
    assert Path("a.svg").is_file()
    setups = [yaml.safe_load(block) for block in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)]
    assert [setup.get("driver") for setup in setups[:2]] == ["gap", "pid"]
    for i, setup in enumerate(setups[:2]):
        Path(f"{i}.yaml").write_text(yaml.safe_dump(setup))
        again = firstlap.load_setup(f"{i}.yaml")
        assert again.values() == firstlap.load_setup(setup["driver"]).values()


def test_an_html_report_stands_alone(cli):
    assert cli(*QUICK, "--drivers", "gap,pid", "--report", "a.html").code == 0
    text = Path("a.html").read_text()
    assert "data:image/png;base64," in text
    assert "<table>" in text
    assert [path.name for path in Path().iterdir() if path.is_file()] == ["a.html"]


def test_a_race_that_fails_shows_in_the_exit_code_and_the_table(cli):
    Path("wild.yaml").write_text("driver: pid\nspeed: {v_min: 9, v_max: 12, a_y_max: 20}\n")
    ran = cli(*QUICK, "--drivers", "pid,pid:wild.yaml", "--report", "a.md", "--json")
    assert ran.code == 1
    row = ran.json["entries"][1]
    assert (row["finished"], row["median"], row["relative"], row["min_clearance"]) == (0, None, None, 0.0)
    assert ran.json["reference"] == "pid"
    assert "0 of 2" in Path("a.md").read_text()


BAD = {
    "unknown driver": (("--drivers", "gap,gobal"), "'gobal' is not a driver"),
    "unknown setup": (("--drivers", "gap:nothing"), "no such setup"),
    "setup of another driver": (("--drivers", "gap:base"), "is for driver local, not for gap"),
    "twice": (("--drivers", "gap,gap"), "gap is named twice"),
    "empty": (("--drivers", "gap,,pid"), "expected comma-separated DRIVER or DRIVER:SETUP"),
    "no setup after the colon": (("--drivers", "gap:"), "expected comma-separated DRIVER or DRIVER:SETUP"),
    "latency": (("--latency", "some"), "expected measured, none, or fixed:MS"),
    "report of no kind": (("--report", "a.docx"), ".md, .html"),
    "report nowhere": (("--report", "no/such/a.md"), "no such folder"),
    "report on a folder": (("--report", "folder.md"), "is a folder"),
    "picture of no kind": (("--plot", "a.txt"), ".png"),
    "store in a file": (("--store", "file"), "cannot create the folder for races"),
    "no laps": (("--laps", "0"), "laps"),
    "unknown car": (("--car", "truck"), "no such car"),
}


@pytest.mark.parametrize(("arguments", "reason"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line_and_exit_2(cli, arguments, reason):
    Path("folder.md").mkdir()
    Path("file").write_text("here")
    answer = cli("compare", "oval", "--store", "races", *arguments)
    assert answer.code == 2
    assert re.fullmatch(r"error: .+\n", answer.err)
    assert reason in answer.err
    assert answer.out == ""


def test_relative_is_to_global_where_it_raced():
    rows = [row_of("gap", 10.0), row_of("global", 11.0), row_of("local", 12.0), row_of("pid", None)]
    assert reference_row(rows)["label"] == "global"
    assert reference_row(rows[:1] + rows[2:])["label"] == "gap"
    assert reference_row([]) is None
    order = group_gaps(best_of_groups(rows))
    assert order["gaps"]["reactive_to_local"]["ours"] == pytest.approx(10 / 12 - 1)
    assert order["gaps"]["local_to_global"]["ours"] == pytest.approx(12 / 11 - 1)
    assert order["gaps"]["reactive_to_local"]["paper"] == pytest.approx(0.25)
    assert group_gaps(best_of_groups(rows[:1]))["gaps"]["local_to_global"]["ours"] is None


def row_of(driver: str, median: float | None, setup: str = "", tuned_for: str | None = None) -> dict[str, Any]:
    """A row of the table, of those keys that the summary reads."""
    finished = 0 if median is None else 2
    label = f"{driver}:{setup}" if setup else driver
    rate = finished / 2
    return {"driver": driver, "setup": setup or driver, "label": label, "median": median, "success_rate": rate,
            "finished": finished, "runs": 2, "tuned_for": tuned_for}  # fmt: skip


def test_by_default_the_fastest_general_setup_and_the_papers_are_raced_too():
    labels = [entry.label for entry in parse_entries(None, CAR)]
    assert labels == ["local", "local:brisk", "local:race", "gap", "disparity", "pid", "global"]


def test_the_summary_has_the_papers_setting_and_the_best_and_says_which_are_tuned():
    rows = [
        row_of("local", 14.0),
        row_of("local", 11.0, "brisk", "unknown tracks"),
        row_of("local", 13.0, "race", "the track of the paper's race"),
        row_of("disparity", 12.0, tuned_for="unknown tracks"),
        row_of("global", 10.0),
    ]
    published, best = group_gaps(published_of_groups(rows)), group_gaps(best_of_groups(rows))
    assert published["laps"]["local"]["label"] == "local:race"
    assert best["laps"]["local"]["label"] == "local:brisk"
    lines = order_lines({"entries": rows, "published": published, "order": best})
    assert lines == [
        "the paper's setting: reactive (disparity, tuned for unknown tracks, 12.00 s) compared with local (local:race, "
        "tuned for the track of the paper's race, 13.00 s): -7.7% per lap; in the paper +25.0%",
        "the paper's setting: local (local:race, tuned for the track of the paper's race, 13.00 s) compared with "
        "global (global, untuned, 10.00 s): +30.0% per lap; in the paper +8.3%",
        "the fastest setups: reactive (disparity, tuned for unknown tracks, 12.00 s) compared with local (local:brisk, "
        "tuned for unknown tracks, 11.00 s): +9.1% per lap; in the paper +25.0%",
        "the fastest setups: local (local:brisk, tuned for unknown tracks, 11.00 s) compared with global (global, "
        "untuned, 10.00 s): +10.0% per lap; in the paper +8.3%",
    ]


def test_the_table_on_the_terminal_says_what_is_tuned(cli):
    said = cli(*QUICK, "--drivers", "disparity:disparity_arena,local,gap", "--laps", 1, "--seeds", 1)
    assert said.code == 0, said.err
    for words in ("unknown tracks", "untuned", "arena"):
        assert re.search(rf"│ {words} +│", said.out), words


def test_a_papers_setting_that_fails_is_not_replaced_by_a_better_one():
    rows = [row_of("local", None, "race"), row_of("local", 11.0, "brisk"), row_of("gap", 12.0)]
    published = group_gaps(published_of_groups(rows))
    assert published["gaps"]["reactive_to_local"]["ours"] is None
    lines = order_lines({"entries": rows, "published": published, "order": group_gaps(best_of_groups(rows))})
    assert lines[0] == "the paper's setting (local:race): 0 of 2 races finished"


@pytest.mark.parametrize("name", list_setups())
def test_a_setup_file_says_what_it_was_tuned_for(name):
    """What a search found says so in its comments; the summary reads it from the file's line."""
    setup = load_setup(name)
    comments = " ".join(line for line in Path(setup.source).read_text().splitlines() if line.startswith("#"))
    assert bool(re.search("found by a search|tuned to that|firstlap tune|Found by a search", comments)) == bool(
        setup.tuned_for
    )


def test_of_rows_that_often_fail_none_is_the_reference():
    rows = [
        {"driver": "gap", "label": "gap", "median": 9.0, "success_rate": 0.2},
        {"driver": "pid", "label": "pid", "median": 12.0, "success_rate": 1.0},
    ]
    assert reference_row(rows)["label"] == "pid"


# A driver in Python with a preparation; it must be importable in the processes that race it.
class Planned:
    """A Python wrapper of the driver pid."""

    def __init__(self, top_speed: float) -> None:
        params = _core.CenterPidParams()
        params.set("speed", "v_max", top_speed)
        self.pid = _core.CenterPid(params)

    def step(self, scan: _core.LaserScan, state: _core.VehicleState, dt: float) -> Any:
        """One step."""
        return self.pid.step(scan, state, dt)

    def reset(self) -> None:
        """Resets the driver."""
        self.pid.reset()


def _prepare(track: Any, _setup: Any, _car: Any, _seed: int, on_progress: Any) -> Preparation:
    if on_progress:
        on_progress("measuring", 1.0)
    return Preparation(seconds=12.5, given=2.0 + 0.0 * track.length)


def driver_kind() -> DriverKind:
    """Registers the driver."""
    fields = DRIVERS["pid"].fields
    return DriverKind(
        name="planned",
        title="a test",
        fields=fields,
        new_params=lambda: TableParams(fields),
        make=lambda _values, _car, prepared: CoreHandle(_core.CallbackDriver(Planned(prepared.given))),
        default_setup="planned",
        needs_map=True,
        in_python=True,
        prepare=_prepare,
    )


def test_drivers_in_python_race_in_processes_with_what_they_prepared(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    DRIVERS.register(driver_kind())
    try:
        setup = firstlap.Setup("planned", driver="planned")
        looks: list[tuple[str, str, float]] = []
        entry = Entry(setup)
        contest = Comparison(
            firstlap.load_track("oval"), [entry], CAR, laps=1, seeds=2, latency="none", store=Store(tmp_path), jobs=1
        )
        monkeypatch.setattr("firstlap.evaluation.compare.compare._Processes.begin", staticmethod(register_here))
        contest.drive(preparing=lambda e, what, share: looks.append((e.label, what, share)))
        row = contest.to_dict()["entries"][0]
        assert (row["finished"], row["preparation"], row["needs_map"]) == (2, 12.5, True)
        assert row["mean_speed"] <= 2.0
        assert looks == [("planned", "measuring", 1.0)]
    finally:
        DRIVERS.forget("planned")


def register_here() -> None:
    """Called in each process before its first race."""
    DRIVERS.register(driver_kind())


def test_conditions_hold_for_every_driver(cli):
    ran = cli(*QUICK, "--drivers", "pid", "--option", "mu_scale=0.9", "--seeds", 1, "--report", "a.md", "--json")
    assert ran.json["options"] == {"mu_scale": 0.9}
    assert "--option mu_scale=0.9" in Path("a.md").read_text()


def test_json_is_one_object_and_nothing_else(cli):
    ran = cli(*QUICK, "--drivers", "pid", "--json")
    assert ran.err == ""
    assert set(json.loads(ran.out)) >= {"version", "track", "entries", "reference", "order", "latency", "seeds"}
