"""The ring of rows: what was written is read once, in order; what was overwritten is counted as lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from musclewire.extras.live._ring import SLOTS, RowRing, create_ring


@pytest.fixture
def ends(tmp_path: Path) -> tuple[RowRing, RowRing]:
    create_ring(tmp_path / "ring")
    return RowRing(tmp_path / "ring"), RowRing(tmp_path / "ring")


def test_rows_come_out_as_they_went_in_by_layout(ends: tuple[RowRing, RowRing]) -> None:
    writer, reader = ends
    for number in range(5):
        writer.write(1, [float(number), 0.5])
    writer.write(2, [9.0, np.nan, 7.0])
    cursor, rows, lost = reader.read(0)
    assert (cursor, lost) == (6, 0)
    assert [(part.layout, part.values.shape) for part in rows] == [(1, (5, 2)), (2, (1, 3))]
    assert rows[0].values[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    np.testing.assert_array_equal(rows[1].values, [[9.0, np.nan, 7.0]])
    assert reader.read(cursor) == (6, [], 0)


def test_who_begins_now_gets_none_of_what_was(ends: tuple[RowRing, RowRing]) -> None:
    writer, reader = ends
    writer.write(1, [1.0])
    assert reader.read(-1) == (1, [], 0)


def test_a_reader_that_was_away_is_told_what_it_lost(ends: tuple[RowRing, RowRing]) -> None:
    writer, reader = ends
    for number in range(SLOTS + 100):
        writer.write(1, [float(number)])
    cursor, rows, lost = reader.read(0)
    assert cursor == SLOTS + 100
    assert lost == cursor - len(rows[0].values)
    assert rows[0].values[-1, 0] == SLOTS + 99


def test_a_row_that_is_being_overwritten_is_left_out(ends: tuple[RowRing, RowRing]) -> None:
    writer, reader = ends
    writer.write(1, [1.0])
    writer.write(1, [2.0])
    writer._slots[1, -1] = 99.0  # as in the middle of the next writing of this slot
    _, rows, lost = reader.read(0)
    assert rows[0].values.tolist() == [[1.0]]
    assert lost == 1
