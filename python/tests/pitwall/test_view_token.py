"""Sources of the pit wall's token; never the command line, which all users of a machine can read."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from firstlap.cli.view import TOKEN_VARIABLE, _token
from firstlap.common.errors import InputError


def test_a_token_comes_from_a_file_standard_input_or_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    assert _token(None) is None
    monkeypatch.setenv(TOKEN_VARIABLE, "of the environment")
    assert _token(None) == "of the environment"
    file = tmp_path / "token"
    file.write_text("of the file \nand a second line\n")
    assert _token(file) == "of the file"
    monkeypatch.setattr("sys.stdin", io.StringIO("of the pipe\n"))
    assert _token(Path("-")) == "of the pipe"


def test_a_file_that_is_none_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        _token(tmp_path / "nothing")
    (tmp_path / "empty").touch()
    with pytest.raises(InputError, match="empty; expected a file with a token"):
        _token(tmp_path / "empty")


def test_the_command_line_takes_no_token(cli) -> None:
    ran = cli("view", "oval", "--token", "green flag / 1")
    assert ran.code == 2
    assert "--token-file" in ran.err
