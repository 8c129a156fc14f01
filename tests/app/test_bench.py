"""``musclewire bench`` prints ratios with the work that they are for, and one JSON document on request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def test_a_row_has_the_keys_of_the_interface(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("bench", "--quick", "--only", "step[10ms,numba]", "--json")
    assert answer.code == 0, answer.err
    assert answer.err == ""
    assert set(answer.json) == {"rows", "left_out", "machine", "quick", "wall_s"}
    (row,) = answer.json["rows"]
    assert {"name", "ours_us", "theirs_us", "theirs", "ratio", "work", "turns"} <= set(row)
    assert row["name"] == "step[10ms,numba]"
    assert min(row["ours_us"], row["theirs_us"], row["ratio"]) > 0.0


def test_the_table_says_what_the_time_is_for_and_on_which_machine(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("bench", "--quick", "--only", "closed_loop_period")
    assert answer.code == 0, answer.err
    assert "solve_ivp" in answer.out
    assert "What the time is for" in answer.out
    assert "Gflop/s" in answer.out
    assert "1 of 1: closed_loop_period" in answer.err


def test_an_unknown_name_is_one_line(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("bench", "--only", "stap")
    assert (answer.code, answer.out) == (2, "")
    assert "did you mean 'step'" in answer.err
