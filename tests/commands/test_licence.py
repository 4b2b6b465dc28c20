"""The note on TetGen's licence is printed once, and to a terminal only."""

import io
import sys

import pytest

from craftmesh.commands.licence import licence_note


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def printed(tmp_path, monkeypatch):
    def print_to(stream):
        monkeypatch.setattr(sys, "stderr", stream)
        licence_note()
        return stream.getvalue()

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return print_to


def test_once_per_user_in_one_line(printed):
    first = printed(Terminal())
    assert "AGPL-3.0" in first and first.count("\n") == 1
    assert printed(Terminal()) == ""


def test_a_log_has_no_note_and_does_not_count(printed):
    assert printed(io.StringIO()) == ""
    assert "AGPL" in printed(Terminal())


def test_a_cache_folder_that_cannot_be_made_does_not_stop_a_mesh(printed, tmp_path):
    (tmp_path / "cache").write_text("a file")
    assert "AGPL" in printed(Terminal())
