"""Target trajectories: the paper's staircase, and a user's own."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import Staircase, sampled_reference, staircase
from musclewire.errors import CallerError

PAPER_LEVELS = (0.015, 0.018, 0.021, 0.024, 0.027, 0.03, 0.027, 0.024, 0.021, 0.018, 0.015)


def test_the_default_is_the_papers_staircase_to_the_digit() -> None:
    stairs = staircase()
    assert stairs.levels == PAPER_LEVELS
    assert stairs.hold_s == 6.0
    assert stairs.duration_s == 66.0


def test_the_top_belongs_to_the_rise_as_in_table_2() -> None:
    directions = [(step.target, step.direction) for step in staircase().steps]
    assert directions[:6] == [(level, "rise") for level in PAPER_LEVELS[:6]]
    assert directions[6:] == [(level, "return") for level in PAPER_LEVELS[6:]]


def test_steps_follow_each_other_without_a_gap() -> None:
    steps = staircase().steps
    assert [step.index for step in steps] == list(range(11))
    assert (steps[0].start_s, steps[-1].stop_s) == (0.0, 66.0)
    assert all(before.stop_s == after.start_s for before, after in pairwise(steps))


def test_the_fingers_staircase_in_metres_ends_where_the_paper_does() -> None:
    stairs = staircase(start=0.0025, stop=0.006, increment=0.0005)
    assert stairs.levels[:8] == (0.0025, 0.003, 0.0035, 0.004, 0.0045, 0.005, 0.0055, 0.006)
    assert len(stairs.levels) == 15


def test_one_way_stairs_stop_at_the_top() -> None:
    assert staircase(return_trip=False).levels == PAPER_LEVELS[:6]


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


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=20), st.floats(0.01, 100.0))
def test_every_step_of_any_staircase_shows_its_own_level_in_its_middle(levels: list[float], hold_s: float) -> None:
    stairs = Staircase(tuple(levels), hold_s)
    for step in stairs.steps:
        assert stairs.target_at((step.start_s + step.stop_s) / 2.0) == step.target


def test_a_level_that_repeats_keeps_the_direction() -> None:
    directions = [step.direction for step in Staircase((0.1, 0.1, 0.2, 0.2, 0.1, 0.1, 0.2), 1.0).steps]
    assert directions == ["rise", "rise", "rise", "rise", "return", "return", "rise"]


def test_levels_may_come_as_an_array() -> None:
    assert Staircase(np.array([0.1, 0.2]), 1.0).levels == (0.1, 0.2)  # type: ignore[arg-type]


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


def test_a_sampled_reference_does_not_change_with_the_callers_array() -> None:
    targets = np.array([0.01, 0.02])
    reference = sampled_reference([0.0, 1.0], targets)
    targets[:] = 9.0
    assert reference.target_at(1.5) == 0.02


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"increment": 0.0}, "increment above zero"),
        ({"increment": 0.004}, "miss the stop; try 0.00375"),
        (
            {"increment": 0.004, "shown_as": (100.0, "%")},
            "from 1.5 % to 3 %: increments of 0.4 % miss the stop; try 0.375 %",
        ),
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
    ("ask", "message"),
    [
        (lambda: sampled_reference([], []), "two columns"),
        (lambda: sampled_reference([0.0, 1.0], [0.1]), "two columns"),
        (lambda: sampled_reference([0.0, 1.0], [0.1, math.nan]), "row 1"),
        (lambda: sampled_reference([0.0, 1.0, 1.0], [0.1, 0.2, 0.3]), "row 2 has 1.0 s"),
        (lambda: Staircase((), 1.0), "finite levels"),
        (lambda: staircase().target_at(math.nan), "finite time"),
        (lambda: staircase().targets_at([0.0, math.inf]), "finite times"),
    ],
)
def test_a_reference_or_a_time_that_makes_no_sense_is_refused(ask: Callable[[], object], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        ask()
