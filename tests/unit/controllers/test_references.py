"""Target trajectories: the paper's staircase, and a user's own."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers._references import Staircase, sampled_reference, staircase
from musclewire.errors import CallerError

PAPER_LEVELS = (0.015, 0.018, 0.021, 0.024, 0.027, 0.03, 0.027, 0.024, 0.021, 0.018, 0.015)


def test_the_default_is_the_papers_staircase_to_the_digit() -> None:
    stairs = staircase()
    assert stairs.levels == PAPER_LEVELS
    assert (stairs.hold_s, stairs.duration_s) == (6.0, 66.0)
    assert staircase(return_trip=False).levels == PAPER_LEVELS[:6]
    fingers = staircase(start=0.0025, stop=0.006, increment=0.0005).levels
    assert fingers[:8] == (0.0025, 0.003, 0.0035, 0.004, 0.0045, 0.005, 0.0055, 0.006)
    assert len(fingers) == 15


def test_the_top_belongs_to_the_rise_as_in_table_2() -> None:
    directions = [(step.target, step.direction) for step in staircase().steps]
    assert directions[:6] == [(level, "rise") for level in PAPER_LEVELS[:6]]
    assert directions[6:] == [(level, "return") for level in PAPER_LEVELS[6:]]


@pytest.mark.parametrize(
    ("time_s", "target"),
    [
        (-1.0, 0.015),
        (0.0, 0.015),
        (5.95, 0.015),
        (6.0, 0.018),
        (30.0, 0.03),
        (36.0, 0.027),
        (66.0, 0.015),
        (1e9, 0.015),
    ],
)
def test_the_target_changes_at_the_start_of_its_step_and_stays_after_the_end(time_s: float, target: float) -> None:
    assert staircase().target_at(time_s) == target


def test_a_clock_that_adds_up_ticks_meets_every_step_on_time() -> None:
    stairs = staircase()
    time_s = 0.0
    for tick in range(66 * 20):
        assert stairs.target_at(time_s) == PAPER_LEVELS[tick // 120]
        time_s += 0.05


@given(st.lists(st.floats(-10.0, 80.0), max_size=30))
def test_many_targets_equal_one_at_a_time(times_s: list[float]) -> None:
    stairs = staircase()
    sampled = sampled_reference([0.0, 6.0, 7.5], [0.01, 0.02, 0.015])
    assert stairs.targets_at(times_s).tolist() == [stairs.target_at(time) for time in times_s]
    assert sampled.targets_at(times_s).tolist() == [sampled.target_at(time) for time in times_s]


def test_a_level_that_repeats_keeps_the_direction() -> None:
    directions = [step.direction for step in Staircase((0.1, 0.1, 0.2, 0.2, 0.1, 0.1, 0.2), 1.0).steps]
    assert directions == ["rise", "rise", "rise", "rise", "return", "return", "rise"]


def test_a_sampled_reference_holds_each_value_until_the_next() -> None:
    reference = sampled_reference([1.0, 2.0, 4.0], [0.01, 0.03, 0.02])
    assert [reference.target_at(time) for time in (0.0, 1.0, 1.99, 2.0, 3.9, 4.0, 9.0)] == [
        0.01,
        0.01,
        0.01,
        0.03,
        0.03,
        0.02,
        0.02,
    ]
    assert reference.duration_s == 4.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"increment": 0.0}, "increment above zero"),
        ({"increment": 0.004}, "miss the stop; try 0.00375"),
        ({"increment": 1.0}, "miss the stop"),
        ({"start": 0.03, "stop": 0.015}, "stop must be above start"),
        ({"start": math.nan}, "finite"),
        ({"hold_s": 0.0}, "hold_s"),
        ({"hold_s": math.inf}, "hold_s"),
    ],
)
def test_stairs_that_make_no_sense_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        staircase(**arguments)


@pytest.mark.parametrize(
    ("times_s", "targets", "message"),
    [
        ([0.0, 1.0], [0.1], "two columns"),
        ([0.0, 1.0], [0.1, math.nan], "row 1"),
        ([0.0, 1.0, 1.0], [0.1, 0.2, 0.3], "row 2 has 1.0 s"),
    ],
)
def test_a_sampled_reference_that_makes_no_sense_is_refused(
    times_s: list[float], targets: list[float], message: str
) -> None:
    with pytest.raises(CallerError, match=message):
        sampled_reference(times_s, targets)


def test_the_target_at_no_time_is_refused() -> None:
    with pytest.raises(CallerError, match="finite time"):
        staircase().target_at(math.nan)
    with pytest.raises(CallerError, match="finite times"):
        staircase().targets_at([0.0, math.inf])
