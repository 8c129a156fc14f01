"""A journal cut or changed at any byte gives rows that were written, from the first one on, or one line of error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.signals._journal import encoded_end, encoded_rows, encoded_start, parsed_journal

COLUMNS = ("time_s", "wire_voltage_v", "displacement_m")
NAME = Path("run.h5.journal")
TABLE = np.arange(60.0).reshape(20, 3)
START = encoded_start(COLUMNS, {"wire": "Flexinol", "legs": 2, "rig": None})
# Blocks of five rows.
BLOCKS = [encoded_rows(TABLE[first : first + 5].tobytes()) for first in range(0, 20, 5)]
END = encoded_end("done", {"deadline_misses": 3})
WHOLE = b"".join([START, *BLOCKS, END])


def test_all_that_was_written_is_read() -> None:
    journal = parsed_journal(WHOLE, NAME)
    assert journal.columns == COLUMNS
    assert np.array_equal(journal.values, TABLE)
    assert dict(journal.metadata) == {"wire": "Flexinol", "legs": 2, "rig": None, "deadline_misses": 3}
    assert (journal.ended, journal.damaged_bytes) == ("done", 0)


def test_the_first_lines_say_what_it_is_and_what_to_do() -> None:
    first, second = WHOLE.splitlines()[:2]
    assert first == b"musclewire-journal 1"
    assert b"musclewire recover" in second


@given(st.integers(0, len(WHOLE)))
def test_cut_anywhere_it_has_exactly_the_whole_blocks_before(length: int) -> None:
    if length < len(START):
        with pytest.raises(RecordingError, match=r"^run\.h5\.journal: is "):
            parsed_journal(WHOLE[:length], NAME)
        return
    journal = parsed_journal(WHOLE[:length], NAME)
    blocks = min((length - len(START)) // len(BLOCKS[0]), len(BLOCKS))
    assert np.array_equal(journal.values, TABLE[: 5 * blocks])
    assert journal.ended == ("done" if length == len(WHOLE) else "")
    assert journal.damaged_bytes == 0


@given(st.integers(0, len(WHOLE) - 1), st.integers(1, 255))
def test_a_changed_byte_never_changes_a_row(place: int, change: int) -> None:
    data = bytearray(WHOLE)
    data[place] ^= change
    try:
        journal = parsed_journal(bytes(data), NAME)
    except RecordingError:
        assert place < len(START)
        return
    assert np.array_equal(journal.values, TABLE[: len(journal.values)])
    if place >= len(START):
        assert len(journal.values) >= 5 * ((place - len(START)) // len(BLOCKS[0]))


@given(st.binary(max_size=300))
def test_what_follows_the_last_block_is_no_row(rest: bytes) -> None:
    journal = parsed_journal(b"".join([START, *BLOCKS]) + rest, NAME)
    assert np.array_equal(journal.values, TABLE)
    assert journal.ended == ""


def test_blocks_that_a_power_cut_left_empty_are_no_damage_and_anything_else_is() -> None:
    assert parsed_journal(START + BLOCKS[0] + bytes(4096), NAME).damaged_bytes == 0
    damaged = bytearray(START + BLOCKS[0] + BLOCKS[1])
    damaged[-1] ^= 1
    assert parsed_journal(bytes(damaged), NAME).damaged_bytes == len(BLOCKS[1])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is not a journal of musclewire"),
        (b"\x89HDF\r\n\x1a\n", "is not a journal of musclewire"),
        (WHOLE.replace(b"journal 1", b"journal 2", 1), "is a journal of version 2, this musclewire reads 1; update"),
        (START.splitlines()[0], "damaged journal"),
        (encoded_start(["time_s", "time_s"], {}), "damaged journal"),
        (encoded_start([], {}), "damaged journal"),
        (WHOLE[: START.index(b"\n") + 1], "damaged journal"),
    ],
)
def test_what_is_no_journal_of_ours_is_said_in_one_line(data: bytes, message: str) -> None:
    with pytest.raises(RecordingError, match=message) as caught:
        parsed_journal(data, NAME)
    assert "\n" not in str(caught.value)


def test_rows_of_another_width_are_no_rows() -> None:
    journal = parsed_journal(START + encoded_rows(np.arange(4.0).tobytes()), NAME)
    assert journal.values.shape == (0, 3)
