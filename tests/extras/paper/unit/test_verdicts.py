"""How a row is judged by its median over seeds, on numbers made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import quantile_test

from musclewire.extras.paper import PaperCheck, ReproductionRow, SeedResult, row_of_check
from musclewire.extras.paper._reproduce.paper_checks import Compare, holds
from musclewire.extras.paper._reproduce.verdicts import counts_by_origin, median_interval, spread_of

NUMBERS = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=60)


def check(compare: Compare = "within", paper: float = 2.0, tolerance: float = 0.5) -> PaperCheck:
    return PaperCheck(
        "fig0.number", paper, "ohm", tolerance, "because", "printed", lambda _: 0.0, compare, origin="fitted"
    )


def row(*ours: float | None, compare: Compare = "within") -> ReproductionRow:
    found = [SeedResult(None, "no loop") if number is None else SeedResult(number) for number in ours]
    return row_of_check(check(compare), found, {})


@pytest.mark.parametrize("count", range(6, 140, 7))
def test_the_interval_is_that_of_scipy(count: int) -> None:
    values = np.random.default_rng(count).normal(size=count)
    theirs = quantile_test(values, p=0.5).confidence_interval(0.95)
    assert median_interval(values.tolist()) == pytest.approx((theirs.low, theirs.high))


@given(NUMBERS)
def test_the_spread_is_in_order_and_does_not_depend_on_the_order_of_seeds(values: list[float]) -> None:
    found = spread_of(values)
    assert min(values) <= found.low <= found.ours <= found.high <= max(values)
    assert found.median_low <= found.ours <= found.median_high
    assert row(*reversed(values)) == row(*values)


@given(NUMBERS, st.sampled_from(["within", "at most", "at least"]))
def test_a_row_holds_where_all_of_its_interval_does_and_fails_where_none_does(
    values: list[float], compare: Compare
) -> None:
    found = row(*values, compare=compare)
    between = np.linspace(*median_interval(values), 201)
    inside = [holds(check(compare), float(place)) for place in between]
    if found.verdict == "holds":
        assert all(inside)
    elif found.verdict == "fails":
        assert not any(inside)
    assert found.ok == (found.verdict == "holds")


def test_a_limit_inside_the_interval_is_at_the_bar_whatever_the_median() -> None:
    below, above = (row(*(middle + 0.01 * seed for seed in range(-10, 11))) for middle in (2.49, 2.51))
    assert (below.verdict, above.verdict) == ("at the bar", "at the bar")
    assert not below.ok
    assert (row(2.5).verdict, row(2.51).verdict) == ("holds", "fails")
    assert row(*(2.2 + 0.01 * seed for seed in range(-10, 11))).verdict == "holds"
    assert row(*(2.8 + 0.01 * seed for seed in range(-10, 11))).verdict == "fails"


def test_seeds_without_a_number_are_counted_and_a_tenth_of_them_fails_the_row() -> None:
    few, many = row(*[2.0] * 19, None), row(*[2.0] * 18, None, None)
    assert (few.ours, few.seeds, few.verdict) == (2.0, 19, "holds")
    assert few.problem == "1 of 20 seeds have no number: no loop"
    assert (many.ours, many.seeds, many.verdict) == (2.0, 18, "fails")
    assert many.problem == "2 of 20 seeds have no number: no loop"


def test_a_known_failure_still_fails_and_carries_its_reason() -> None:
    found = row_of_check(check(), [SeedResult(9.0)], {"fig0.number": "the wire is no wire"})
    assert not found.ok
    assert found.known_failure
    assert found.known_reason == "the wire is no wire"


@pytest.mark.parametrize("ours", [-9.0, 2.0, 1e6])
def test_a_row_that_is_reported_neither_holds_nor_fails(ours: float) -> None:
    found = row(*[ours] * 20, None, compare="reported")
    assert (found.ours, found.verdict, found.ok, found.is_judged) == (ours, "reported", True, False)
    assert row(2.0).is_judged
    assert counts_by_origin([found]) == []


def test_a_row_that_cannot_fail_is_judged_and_not_counted() -> None:
    assert row(2.0).is_counted
    for origin in ("input", "definition", "satisfied"):
        assert not replace(row(2.0), origin=origin).is_counted


def test_a_row_of_one_side_that_holds_by_its_tolerance_is_worse() -> None:
    assert not row(1.9, compare="at most").is_worse
    assert row(2.3, compare="at most").is_worse
    assert row(1.8, compare="at least").is_worse
    assert not row(9.0, compare="at most").is_worse
    assert not row(2.3).is_worse


def test_a_row_that_cannot_be_reported_fails() -> None:
    found = row(None, None, compare="reported")
    assert (found.ok, found.is_judged) == (False, True)
