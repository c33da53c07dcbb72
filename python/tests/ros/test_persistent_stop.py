"""The state that a driving node leaves to the next one if it dies."""

from __future__ import annotations

from pathlib import Path

import pytest

from firstlap.ros.persistent_stop import DRIVING, EMERGENCY, PersistentStop


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the state."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def test_the_next_node_of_this_name_and_domain_reads_what_the_last_one_left(folder: Path) -> None:
    kept = PersistentStop("/firstlap_drive", 7)
    assert kept.read() == ""
    for output in (DRIVING, EMERGENCY):
        kept.keep(output)
        assert PersistentStop("/firstlap_drive", 7).read() == output
    assert PersistentStop("/firstlap_drive", 8).read() == ""
    assert PersistentStop("/car1/firstlap_drive", 7).read() == ""
    kept.keep("")
    kept.keep("")
    assert PersistentStop("/firstlap_drive", 7).read() == ""
    assert list(folder.iterdir()) == []


def test_what_is_not_ours_is_nothing_and_a_folder_that_cannot_be_written_to_does_no_harm(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = PersistentStop("/firstlap_drive", 7)
    kept.keep(DRIVING)
    (file,) = folder.iterdir()
    file.write_bytes(b"\xff" * 10_000)
    assert kept.read() == ""
    target = folder / "elsewhere"
    target.write_text(DRIVING)
    file.unlink()
    file.symlink_to(target)
    assert kept.read() == ""
    kept.keep(EMERGENCY)
    assert (target.read_text(), kept.read()) == (DRIVING, EMERGENCY)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder / "nowhere"))
    lost = PersistentStop("/firstlap_drive", 7)
    lost.keep(EMERGENCY)
    assert lost.read() == ""
