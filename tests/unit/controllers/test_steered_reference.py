"""A steered target: the loop follows from its next sample on, and what was asked when stays known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import SteeredReference
from musclewire.errors import CallerError

# What a loop does: at each sample it asks for the target of the last one, then for the present one.
PERIOD_S = 0.05


@given(st.lists(st.none() | st.floats(0.0, 1.0), min_size=1, max_size=60))
def test_a_sample_is_judged_by_the_target_that_its_controller_had(moves: list[float | None]) -> None:
    reference = SteeredReference(0.5, lowest=0.0, highest=1.0)
    had = [reference.target_at(0.0)]
    for number, move in enumerate(moves, start=1):
        if move is not None:
            reference.steer(move)
        assert reference.target_at((number - 1) * PERIOD_S) == had[-1]
        had.append(reference.target_at(number * PERIOD_S))
        assert had[-1] == (had[-2] if move is None else move)
    times_s = np.arange(len(had)) * PERIOD_S
    np.testing.assert_array_equal(reference.targets_at(times_s), had)
    assert [reference.target_at(float(time_s)) for time_s in times_s] == had
    assert all(earlier < later for earlier, later in pairwise(reference._starts_s))


@pytest.mark.parametrize("target", [-0.01, 1.01, float("nan"), float("inf")])
def test_a_target_outside_its_range_is_refused_and_changes_nothing(target: float) -> None:
    reference = SteeredReference(0.5, lowest=0.0, highest=1.0)
    with pytest.raises(CallerError, match="outside 0 to 1"):
        reference.steer(target)
    assert reference.target == 0.5


@pytest.mark.parametrize("ends", [(1.0, 0.0), (0.5, 0.5), (float("nan"), 1.0)])
def test_a_range_without_length_is_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(CallerError, match="range"):
        SteeredReference(0.5, lowest=ends[0], highest=ends[1])
