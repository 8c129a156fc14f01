"""Tables are plain text, folded to the width of a terminal where somebody sees them."""

from __future__ import annotations

import sys

import pytest

from musclewire.app import table

HEAD = ("event [ms]", "lasting", "when")
ROWS = [("over_current", "20", "current above what the wire bears, " * 5 + "end"), ("rest", "-", "[always]")]


def test_in_a_narrow_terminal_a_long_cell_is_folded_in_its_column(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "60")
    lines = table(HEAD, ROWS, left=(0, 2)).splitlines()
    assert len(lines) > 4
    assert max(map(len, lines[1:])) <= 60  # the first is bold
    monkeypatch.setenv("COLUMNS", "20")
    assert len(table(HEAD, ROWS, left=(0, 2)).splitlines()) == 3, "nothing is cut off where words do not fit"
