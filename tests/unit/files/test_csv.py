"""Plain CSV as the core alone reads it: what we write, to the bit, and what others write in as few words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.files._plain_csv import read_plain_csv
from musclewire.signals import Recording

NUMBERS = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=2, max_size=20)


@given(rows=NUMBERS)
def test_what_we_write_is_read_to_the_bit(rows: list[float], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    time_s, force_n = np.arange(float(len(rows))), np.array(rows)
    Recording({"time_s": time_s, "force_n": force_n}, {"wire": "a b", "leg_length_m": 0.14}).save(path)
    table = read_plain_csv(path)
    assert [column.header for column in table.columns] == ["time_s", "force_n"]
    assert dict(table.metadata) == {"wire": "a b", "leg_length_m": 0.14}
    assert all(np.array_equal(found, written) for found, written in zip(table.values, (time_s, force_n), strict=True))


def test_names_may_be_anybodys_and_a_blank_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "bench.csv"
    path.write_text('"Time, s",U [mV]\n0,1\n0.5,\n', encoding="utf-8")
    table = read_plain_csv(path)
    assert [column.header for column in table.columns] == ["Time, s", "U [mV]"]
    np.testing.assert_array_equal(table.values[1], [1.0, np.nan])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n3,x\n", "line 3: could not convert string to float: 'x'; correct it, or add the part lab_files"),
        ("# k = 1\na,b\n1,2,3\n", "line 3: has 3 cells for 2 names"),
    ],
)
def test_anything_else_is_refused_with_its_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bench.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=said):
        read_plain_csv(path)
