"""`firstlap tune` from the user's view: output, errors and kept files."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

import firstlap
from firstlap.tuning.study import study_names

pytest.importorskip("optuna", reason="the extra `tune` is not installed")
pytest.importorskip("cmaes", reason="the extra `tune` is not installed")

QUICK = [
    "--seeds",
    "1",
    "--population",
    "4",
    "--only",
    "a_y_max,v_max",
    "--judge",
    "laps=2",
    "--judge",
    "check_laps=2",
    "--judge",
    "check_seeds=2",
    "--judge",
    "finalists=1",
    "--judge",
    "unseen_seeds=2",
]
ALONE = [*QUICK, "--judge", "other_seeds=0"]


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replaces the report, which takes longer than these races."""
    monkeypatch.setattr("firstlap.tuning.report.report", lambda *_: "")


def one_line(ran, *words: str) -> None:
    assert ran.code == 2, ran.err
    lines = ran.err.strip().splitlines()
    assert len(lines) == 1, ran.err
    assert lines[0].startswith("error: ")
    assert "Traceback" not in ran.err
    for word in words:
        assert word in lines[0]


def test_tune_writes_setups_to_race_and_a_report_in_one_file(cli):
    ran = cli("tune", "oval", "--budget", 5, "--json", *ALONE)
    assert ran.code == 0, ran.err
    found = ran.json
    assert (found["study"], found["trials"]) == ("oval-1", 5)
    assert found["holds"]["failed"] == 0
    assert found["holds"]["less"] > 0.0
    assert found["laps_per_second"] == pytest.approx(found["laps"] / found["seconds"], rel=0.02)
    assert f"{found['laps_per_second']:.1f} per second" in Path(found["report"]).read_text(encoding="utf-8")
    text = Path(found["holds"]["file"]).read_text(encoding="utf-8")
    for word in ("oval", "seed 1", firstlap.__version__, "check seeds", "% less"):
        assert word in text
    again = firstlap.race(firstlap.load_track("oval"), found["holds"]["file"], laps=2)
    assert again.finished
    setup = firstlap.load_setup(found["holds"]["file"])
    assert {f"{section}.{name}": value for (section, name), value in setup.given.items()} == found["holds"]["values"]
    assert setup.tuned_for == "oval"
    page = Path(found["report"]).read_text(encoding="utf-8")
    for word in (
        "Lap by setting",
        "Motion parameters",
        "Driven lines",
        "Lap time against clearance",
        "over-tuned",
        "rules",
    ):
        assert word in page
    assert page.count("data:image/png;base64,") >= 5
    assert 'src="http' not in page


@pytest.mark.usefixtures("no_pictures")
def test_the_same_seed_and_number_of_trials_give_the_same_setups_with_any_number_of_workers(cli):
    def found(name: str, workers: int) -> list[object]:
        options = ["--name", name, "--workers", workers, "--no-validate", "--starts", "race"]
        ran = cli("tune", "oval", "--budget", 4, "--json", *QUICK, *options)
        assert ran.code == 0, ran.err
        roles = [ran.json["holds"], ran.json["seen"], ran.json["compared_with"]]
        return [{**role, "file": ""} for role in roles]

    assert found("a", 1) == found("b", 2)


@pytest.mark.usefixtures("no_pictures")
def test_tune_serves_any_driver_of_the_registry(cli):
    options = [word if word != "a_y_max,v_max" else "v_max" for word in ALONE]
    found = cli("tune", "oval", "--driver", "gap", "--lidar", "ld19", "--budget", 2, "--json", *options)
    assert found.code in (0, 1), found.err
    assert (found.json["driver"], found.json["car"]) == ("gap", "default with ld19")
    if found.json["holds"]:
        assert firstlap.load_setup(found.json["holds"]["file"]).driver == "gap"


@pytest.mark.parametrize("budget", ["0", "0m", "-1", "nothing"])
def test_a_budget_of_nothing_is_one_line(cli, budget: str):
    one_line(cli("tune", "oval", "--budget", budget), "--budget", "3m")


def test_a_track_that_no_start_finishes_says_so_and_stops(cli, tmp_path: Path):
    car = tmp_path / "ice.yaml"
    car.write_text("vehicle:\n  friction: 0.06\n", encoding="utf-8")
    ran = cli("tune", "arena", "--car", car, "--budget", 50, *ALONE)
    one_line(ran, "no starting setup finishes it", "base: contact")
    assert not list(tmp_path.glob("tuned/*/*.yaml"))


def test_a_study_file_that_cannot_be_written_is_one_line(cli, tmp_path: Path):
    for file in ("/proc/tuning.db", tmp_path, tmp_path / "nowhere" / "a.db"):
        one_line(cli("tune", "oval", "--budget", 3, "--study", file), str(file))


def test_a_foreign_study_file_is_refused_and_left_as_it_is(cli, tmp_path: Path):
    text = tmp_path / "notes.db"
    text.write_text("not a database", encoding="utf-8")
    other = tmp_path / "other.db"
    with closing(sqlite3.connect(other)) as connection:
        connection.execute("create table songs (name text)")
        connection.commit()
    for file in (text, other):
        before = file.read_bytes()
        one_line(cli("tune", "oval", "--budget", 3, "--study", file), "is not a study file")
        assert file.read_bytes() == before


@pytest.mark.usefixtures("no_pictures")
def test_a_study_of_another_track_or_another_search_is_refused(cli, tmp_path: Path):
    assert cli("tune", "oval", "--budget", 1, "--name", "a", "--no-validate", *QUICK).code == 0
    one_line(cli("tune", "wide", "--budget", 1, "--name", "a", *QUICK), "another track", "oval", "--name")
    one_line(cli("tune", "oval", "--reverse", "--budget", 1, "--name", "a", *QUICK), "another track")
    one_line(cli("tune", "oval", "--budget", 1, "--name", "a", "--seed", 2, *QUICK), "another seed")
    import optuna

    optuna.create_study(storage="sqlite:///firstlap-tuning.db", study_name="theirs").add_trial(
        optuna.trial.create_trial(value=1.0)
    )
    one_line(cli("tune", "oval", "--budget", 1, "--name", "theirs", *QUICK), "not made by firstlap")
    assert study_names(tmp_path / "firstlap-tuning.db") == ["a", "theirs"]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--only", "k_angle"], "k_angle"),
        (["--fix", "k_ang", "--only", "k_ang"], "no parameter is left"),
        (["--judge", "margin=9"], "margin"),
        (["--from", "bse"], "bse"),
        (["--starts", "base,gap"], "gap"),
        (["--starts", ","], "--starts"),
        (["--judge", "frction=0.2"], "spread.friction"),
        (["--judge", "zzz=0.2"], "known: friction"),
        (["--driver", "gapp"], "gapp"),
        (["--name", "../a"], "--name"),
        (["--out", "/proc/out"], "--out"),
    ],
)
def test_other_bad_input_is_one_line(cli, options: list[str], word: str):
    one_line(cli("tune", "oval", "--budget", 1, *options), word)


@pytest.mark.usefixtures("no_pictures")
def test_kill_9_loses_no_finished_trial_and_the_same_command_resumes(cli, tmp_path: Path):
    command = ["tune", "oval", "--name", "a", "--budget", "60", "--json", "--no-validate", *QUICK]
    code = f"import sys; from firstlap.cli import run; sys.exit(run({command!r}))"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL, cwd=tmp_path) as process:
        file = tmp_path / "firstlap-tuning.db"
        end = time.monotonic() + 120
        while time.monotonic() < end and process.poll() is None and finished(file) < 3:
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
    kept = costs(file)
    assert 3 <= len(kept) < 60
    command[command.index("60")] = str(len(kept) + 3)
    found = cli(*command)
    assert found.code == 0, found.err
    assert f"resuming after {len(kept)} trials" in found.err
    assert found.json["trials"] == len(kept) + 3
    assert costs(file)[: len(kept)] == kept


def costs(file: Path) -> list[float]:
    """Numbers of the finished trials."""
    with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as connection:
        rows = connection.execute(
            "select value from trial_values join trials using (trial_id) where state = 'COMPLETE'"
        )
        return [float(row[0]) for row in rows]


def finished(file: Path) -> int:
    """Number of trials in a study file that another process writes."""
    try:
        with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as connection:
            return int(connection.execute("select count(*) from trials where state = 'COMPLETE'").fetchone()[0])
    except sqlite3.Error:
        return 0
