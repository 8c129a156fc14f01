"""How a check is judged and chosen, with measures that need no run."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError, RecordingError
from musclewire.extras.paper import PaperCheck, SeedResult, all_checks, known_failures, selected
from musclewire.extras.paper._reproduce.paper_checks import Compare, holds, measured
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.parameters import read_published

RUNS = RunCache()
CHECKS = all_checks()
NAMES = [check.name for check in CHECKS]


def check(ours: float, compare: Compare = "within", paper: float = 2.0, tolerance: float = 0.5) -> PaperCheck:
    return PaperCheck(
        "fig0.number", paper, "ohm", tolerance, "because", "printed", lambda _: ours, compare, origin="fitted"
    )


@pytest.mark.parametrize(
    ("compare", "holding", "failing"),
    [
        ("within", [1.5, 2.0, 2.5], [1.49, 2.51]),
        ("at most", [-9.0, 2.0, 2.5], [2.51]),
        ("at least", [1.5, 2.0, 9.0], [1.49]),
    ],
)
def test_a_row_holds_up_to_its_tolerance_and_not_beyond(
    compare: Compare, holding: list[float], failing: list[float]
) -> None:
    assert all(holds(check(ours, compare), ours) for ours in holding)
    assert not any(holds(check(ours, compare), ours) for ours in failing)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.0, 1e3))
def test_within_means_neither_above_nor_below_the_tolerance(ours: float, paper: float, tolerance: float) -> None:
    def ok(compare: Compare) -> bool:
        return holds(check(ours, compare, paper, tolerance), ours)

    assert ok("within") == (ok("at most") and ok("at least"))


def test_a_loop_that_cannot_be_used_gives_no_number_and_says_why() -> None:
    def measure(_: RunCache) -> float:
        raise RecordingError("no complete\rcycle")

    gap = PaperCheck("fig0.gap", 1.0, "%", 9.0, "because", "printed", measure, origin="fitted")
    assert measured(gap, RUNS) == SeedResult(None, "no complete cycle")


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_number_that_is_none_is_no_number(number: float) -> None:
    assert measured(check(number, "at least"), RUNS).number is None


@pytest.mark.parametrize(
    ("only", "count"), [("fig4.strain_gap_pct[125um,1.70N]", 1), ("fig4", 4), ("fig3", 18), ("table2.mae_rise", 6)]
)
def test_only_takes_the_rows_that_begin_so(only: str, count: int) -> None:
    chosen = selected(CHECKS, only)
    assert len(chosen) == count
    assert all(item.name.startswith(only) for item in chosen)


def test_only_does_not_cut_a_number_in_two() -> None:
    with pytest.raises(CallerError, match=r"'fig1'; did you mean 'fig1[1-8]"):
        selected(CHECKS, "fig1")
    assert [item.name for item in selected(CHECKS, "table2.mae_return_pct[2")] == [
        f"table2.mae_return_pct[{target}]" for target in (2.1, 2.4, 2.7)
    ]


@pytest.mark.parametrize(
    ("wrong", "right"),
    [("figg4", "fig4"), ("table1.resistence", "table1"), ("isobar ", "isobars"), ("colour", "table1, setup, eq1")],
)
def test_an_unknown_name_is_answered_with_the_nearest(wrong: str, right: str) -> None:
    with pytest.raises(CallerError, match=f"'{wrong}'; (did you mean|known).*{right}"):
        selected(CHECKS, wrong)


def test_every_row_has_its_own_name_a_reason_and_a_tolerance_that_is_a_number() -> None:
    assert [name for name, count in Counter(NAMES).items() if count > 1] == []
    for item in CHECKS:
        assert len(item.why) > 15, item.name
        assert 0.0 <= item.tolerance < math.inf, item.name
        assert item.unit, item.name


def printed_numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        return [number for item in value.values() for number in printed_numbers(item)]
    if isinstance(value, list):
        return [number for item in value for number in printed_numbers(item)]
    return [float(value)] if isinstance(value, int | float) else []


def test_every_printed_number_stands_in_a_row() -> None:
    """Also where it is in the name: a pretension is what a loop was made at."""
    paper = {key: value for key, value in read_published("lan_fan_2010").items() if isinstance(value, dict)}
    in_rows = {round(item.paper, 9) for item in CHECKS}
    pretensions = {1.70, 1.9, 3.22, 4.67}
    settled = {1.0}  # "after one second of each step" is in how the MAE rows are counted
    missing = {round(number, 9) for number in printed_numbers(paper)} - in_rows - pretensions - settled
    assert missing == set()


def test_every_known_failure_is_a_row_and_has_its_reason() -> None:
    assert set(known_failures()) <= set(NAMES)
    assert all(len(reason) > 15 for reason in known_failures().values())
