"""Study files: concurrent processes, damaged files, and modified trials."""

from __future__ import annotations

import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("optuna", reason="the extra 'tune' is not installed")

import optuna

from firstlap.common.errors import InputError
from firstlap.tuning.study import check_study_file, open_study, study_names

ABOUT = {"track": "oval", "track_digest": "0", "direction": "forward"}
VERDICT = {"laps": [9.0], "progress": [1.0], "clearances": [0.2], "margin": 0.1, "outcomes": ["finished"]}
GOOD = {"verdict": VERDICT, "number": 0, "given": {"stanley.k_ang": 0.5}, "start": "base", "seconds": 1.0}


def with_trial(path: Path, **attributes: object) -> None:
    """A study with one trial that has these attributes."""
    open_study(path, "a", ABOUT)
    study = optuna.load_study(study_name="a", storage=f"sqlite:///{path}")
    study.add_trial(optuna.trial.create_trial(value=1.0, user_attrs=attributes))


def test_a_fresh_file_of_another_process_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.db"
    path.touch()
    before = path.stat().st_ino
    check_study_file(path)
    assert study_names(path) == []
    assert path.stat().st_ino == before
    check_study_file(tmp_path / "new.db")
    assert not (tmp_path / "new.db").exists()


def test_processes_that_begin_one_file_at_once_all_find_their_study(tmp_path: Path) -> None:
    path, failed = tmp_path / "a.db", []

    def begin(name: str) -> None:
        try:
            check_study_file(path)
            open_study(path, name, ABOUT)
        except InputError as error:
            failed.append(error)

    threads = [threading.Thread(target=begin, args=(f"s{i}",)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    assert sorted(study_names(path)) == ["s0", "s1", "s2", "s3"]
    assert [file.name for file in tmp_path.iterdir()] == ["a.db"]


def test_what_others_add_is_kept_and_of_no_matter(tmp_path: Path) -> None:
    path = tmp_path / "a.db"
    with_trial(path, **GOOD, note="by the dashboard")
    study = optuna.load_study(study_name="a", storage=f"sqlite:///{path}")
    study.set_user_attr("dashboard:note", "fine")
    study.add_trial(optuna.trial.create_trial(value=1.0, user_attrs={"theirs": 1}))
    assert list(open_study(path, "a", ABOUT).trials) == [0]


@pytest.mark.parametrize(
    "changed",
    [
        {"verdict": "none"},
        {"verdict": {}},
        {"verdict": {**VERDICT, "theirs": 1}},
        {"verdict": {**VERDICT, "laps": 3}},
        {"verdict": {**VERDICT, "laps": ["x"]}},
        {"verdict": {**VERDICT, "margin": None}},
        {"given": [1]},
        {"given": {"stanley.k_ang": "x"}},
        {"number": "x"},
        {"number": None},
        {"seconds": []},
    ],
    ids=str,
)
def test_a_trial_that_was_changed_is_one_line(tmp_path: Path, changed: dict[str, object]) -> None:
    path = tmp_path / "a.db"
    with_trial(path, **{**GOOD, **changed})
    with pytest.raises(InputError, match=r"a\.db: study 'a': trial 0 was modified or damaged"):
        open_study(path, "a", ABOUT)


@pytest.mark.parametrize("about", ["text", [1], None, 3])
def test_a_foreign_attribute_of_our_name_is_one_line(tmp_path: Path, about: object) -> None:
    path = tmp_path / "a.db"
    optuna.create_study(study_name="a", storage=f"sqlite:///{path}").set_user_attr("firstlap", about)
    with pytest.raises(InputError, match="was not made by firstlap"):
        open_study(path, "a", ABOUT)


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_file_is_one_line_or_read(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "a.db"
    with_trial(path, **GOOD)
    content, rng = bytearray(path.read_bytes()), np.random.default_rng(seed)
    first = int(rng.integers(100, len(content) - 2000))
    content[first : first + 2000] = rng.bytes(2000)
    path.write_bytes(content[: len(content) // 2] if seed % 4 == 0 else content)
    try:
        study_names(path)
        open_study(path, "a", ABOUT)
    except InputError as error:
        assert str(error).startswith(str(path))


@pytest.mark.parametrize(
    "statement",
    [
        "update trial_user_attributes set value_json = '{'",
        "update study_user_attributes set value_json = 'x'",
        "update trial_values set value_type = 'ODD'",
        "update trials set state = 'ODD'",
        "delete from version_info",
        "drop table trial_user_attributes",
    ],
)
def test_a_file_with_a_wrong_row_is_one_line(tmp_path: Path, statement: str) -> None:
    path = tmp_path / "a.db"
    with_trial(path, **GOOD)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(statement)
        connection.commit()
    try:
        open_study(path, "a", ABOUT)
    except InputError as error:
        assert str(error).startswith(str(path))
