"""A journal remembers what a search did, and never what another one did."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.calibration._physical.search import SearchJournal, read_journal


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "wire.toml.search"


def test_what_was_written_is_remembered_in_order(path: Path) -> None:
    journal = SearchJournal(path, "mine")
    assert journal.descents == []
    journal.write([1.0, 2.0])
    journal.write([0.1, 1e-300])
    again = SearchJournal(path, "mine")
    assert again.descents == [[1.0, 2.0], [0.1, 1e-300]]
    again.remove()
    assert not path.exists()


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=5))
def test_every_number_is_remembered_to_the_bit(tmp_path_factory: pytest.TempPathFactory, numbers: list[float]) -> None:
    path = tmp_path_factory.mktemp("journal") / "j"
    SearchJournal(path, "mine").write(numbers)
    assert read_journal(path, "mine") == [numbers]


def test_a_line_cut_off_in_writing_is_dropped(path: Path) -> None:
    journal = SearchJournal(path, "mine")
    journal.write([1.0, 2.0])
    journal.write([3.0, 4.0])
    path.write_text(path.read_text()[:-4])
    again = SearchJournal(path, "mine")
    assert len(again.descents) == 1
    again.write([5.0])
    assert read_journal(path, "mine") == [[1.0, 2.0], [5.0]]


def test_another_searchs_journal_a_strange_file_and_no_folder_are_refused_and_left_alone(path: Path) -> None:
    SearchJournal(path, "mine").write([1.0])
    with pytest.raises(CallerError, match="belongs to a search with other recordings"):
        SearchJournal(path, "other")
    assert read_journal(path, "mine") == [[1.0]]
    for content in (b"", b"hello\n", b"[1, 2]\n", b"\xff\xfe\x00", b'{"other": 1}\n'):
        path.write_bytes(content)
        with pytest.raises(CallerError, match="is not the journal of a search"):
            SearchJournal(path, "mine")
        assert path.read_bytes() == content
    with pytest.raises(CallerError, match="cannot be written"):
        SearchJournal(path.parent / "none" / "j", "mine")
