"""Compiled reading of plain rows gives the same numbers as ``float()``, or leaves a line to those who look at it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.extras.lab_files._plain_rows import numbers_in

NUMBERS = st.one_of(
    st.floats(1e-4, 1e6).map(lambda value: f"{value:.7g}"),
    st.floats(1e-4, 1e6).map(lambda value: f"{-value:+.9E}"),
    st.integers(-(10**12), 10**12).map(str),
    st.sampled_from([".5", "5.", "-0", "+1e3", "007"]),
)


def read(text: str, width: int, separator: str = ",", decimal: str = ".") -> tuple[np.ndarray, int]:
    table = np.empty((text.count("\n"), width))
    data = np.frombuffer(text.encode(), dtype=np.uint8)
    rows, end = numbers_in(data, ord(separator), ord(decimal), table)
    return table[:rows], end


@given(st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=20), st.sampled_from(["\n", "\r\n"]))
def test_plain_numbers_are_those_of_float_to_the_bit(rows: list[tuple[str, ...]], end: str) -> None:
    text = "".join(",".join(row) + end for row in rows)
    table, read_to = read(text, 3)
    assert read_to == len(text)
    assert table.tolist() == [[float(cell) for cell in row] for row in rows]
    commas, _ = read(text.replace(",", ";").replace(".", ","), 3, ";", ",")
    assert commas.tolist() == table.tolist()


@pytest.mark.parametrize(
    "line",
    ["1,2,3", "1", "1,,", "1,nan", "1, 2", "1,2 V", "1,--2", "1,1e", "1,1e400", "1,12345678901234567", '1,"2"', ""],
)
def test_a_line_of_anything_else_ends_it(line: str) -> None:
    table, read_to = read(f"1,2\n3,4\n{line}\n5,6\n", 2)
    assert table.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert read_to == 8
