"""Lines come out of a file the same however it is divided into pieces, and no line is endless."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.signals import _text_lines as text_lines
from musclewire.signals._reading import read_recording
from musclewire.signals._text_lines import lines_of

PLAIN = "time_s,force_n\n0,1.5\n1,2.5\n"
endings = st.sampled_from(["\n", "\r\n", "\r"])
texts = st.lists(st.sampled_from(["a", "b,c", "", "é;ü", '"x"', "1,2"]), min_size=1, max_size=30)


def lines(path: Path) -> list[str]:
    return [text for piece in lines_of(path) for text in piece.texts]


@settings(max_examples=60, deadline=None)
@given(texts, endings, st.sampled_from(["utf-8", "utf-16", "cp1252"]), st.integers(1, 40))
def test_pieces_of_any_size_give_the_same_lines(found: list[str], end: str, encoding: str, size: int) -> None:
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        path = Path(folder) / "a.csv"
        path.write_bytes(("".join(text + end for text in found)).encode(encoding))
        patch.setattr(text_lines, "_PIECE_BYTES", size)
        assert lines(path) == found


def test_lines_are_numbered_over_the_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.csv").write_text("".join(f"{number}\n" for number in range(1, 200)))
    monkeypatch.setattr(text_lines, "_PIECE_BYTES", 17)
    for piece in lines_of(tmp_path / "a.csv"):
        assert [int(text) for text in piece.texts] == list(range(piece.first, piece.first + len(piece.texts)))


@pytest.mark.parametrize("text", [PLAIN + "1" * 1_100_000, "1" * 9_000_000, PLAIN + "2,3\n" + "x" * 5_000_000 + "\n"])
def test_an_endless_line_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RecordingError, match="which is no row of a table; write one row a line"):
        read_recording(tmp_path / "a.csv")


def test_a_damaged_row_far_into_a_file_is_found_by_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [f"{number},{2 * number}\n" for number in range(5000)]
    rows[4321] = "4321,x\n"
    (tmp_path / "a.csv").write_text("time_s,force_n\n" + "".join(rows))
    monkeypatch.setattr(text_lines, "_PIECE_BYTES", 4096)
    with pytest.raises(RecordingError, match="line 4323, column 'force_n': 'x' is not a number"):
        read_recording(tmp_path / "a.csv")


def test_a_quoted_cell_may_hold_line_ends_and_an_inch_does_not_begin_one(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text('"Time\n[s]",Force [N],Remark\n0,1,5" wire\n1,2,6" wire\n2,3,"two\nlines"\n')
    assert read_recording(path)["force_n"].tolist() == [1.0, 2.0, 3.0]
