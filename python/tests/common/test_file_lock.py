"""Locks of files that only one process at a time may write."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from firstlap.common.errors import InputError
from firstlap.common.file_lock import lock_open_file, locked
from firstlap.recordings.write import _open_alone


def test_a_held_lock_is_refused_and_one_that_a_dead_process_left_is_not(tmp_path: Path) -> None:
    file = tmp_path / "a.db"
    (tmp_path / ".a.db.key.lock").touch()  # as left by a killed process
    with locked(file, "key", "busy"):
        with pytest.raises(InputError, match="busy"), locked(file, "key", "busy"):
            pass
        with locked(file, "other", "busy"):
            pass
    assert not list(tmp_path.iterdir())


def test_who_waits_never_holds_a_lock_file_that_has_lost_its_name(tmp_path: Path) -> None:
    inside, most = [0], [0]

    def work() -> None:
        for _ in range(50):
            with locked(tmp_path / "a.db", "key", "", wait=True):
                inside[0] += 1
                most[0] = max(most[0], inside[0])
                inside[0] -= 1

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1]
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_said_of_the_file(tmp_path: Path) -> None:
    with (
        pytest.raises(InputError, match=r"nowhere/a\.db: cannot be written"),
        locked(tmp_path / "nowhere/a.db", "k", ""),
    ):
        pass


def test_a_log_that_is_being_written_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "race.mcap"
    path.write_bytes(b"an older log")
    with _open_alone(path) as first:
        first.write(b"the race")
        first.flush()
        with pytest.raises(InputError, match=r"race\.mcap: is being written by another process"):
            _open_alone(path)
        assert path.read_bytes() == b"the race"
        with path.open() as other, pytest.raises(InputError, match="busy"):
            lock_open_file(other, path, "busy")
    _open_alone(path).close()
    assert path.read_bytes() == b""
