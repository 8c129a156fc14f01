"""Lines come out of a file the same in every encoding and with every end, and no line is endless."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._text_lines import lines_of
from musclewire.files import read_recording

PLAIN = "time_s,force_n\n0,1.5\n1,2.5\n"
endings = st.sampled_from(["\n", "\r\n", "\r"])
texts = st.lists(st.sampled_from(["a", "b,c", "", "é;ü", '"x"', "1,2"]), min_size=1, max_size=30)


@settings(max_examples=60, deadline=None)
@given(texts, endings, st.sampled_from(["utf-8", "utf-16", "cp1252"]))
def test_encoding_and_ends_change_neither_lines_nor_numbers(found: list[str], end: str, encoding: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        path.write_bytes(("".join(text + end for text in found)).encode(encoding))
        assert list(lines_of(path)) == list(enumerate(found, start=1))


@pytest.mark.parametrize("text", [PLAIN + "1" * 1_100_000, "1" * 9_000_000, PLAIN + "2,3\n" + "x" * 5_000_000 + "\n"])
def test_an_endless_line_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RecordingError, match="which is no row of a table; write one row a line"):
        read_recording(tmp_path / "a.csv")


def test_a_damaged_row_far_into_a_file_is_found_by_its_line(tmp_path: Path) -> None:
    rows = [f"{number},{2 * number}\n" for number in range(80_000)]
    rows[74321] = "74321,x\n"
    (tmp_path / "a.csv").write_text("time_s,force_n\n" + "".join(rows))
    with pytest.raises(RecordingError, match="line 74323, column 'force_n': 'x' is not a number"):
        read_recording(tmp_path / "a.csv")


def test_a_quoted_cell_may_hold_line_ends_and_an_inch_does_not_begin_one(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text('"Time\n[s]",Force [N],Remark\n0,1,5" wire\n1,2,6" wire\n2,3,"two\nlines"\n')
    assert read_recording(path)["force_n"].tolist() == [1.0, 2.0, 3.0]
