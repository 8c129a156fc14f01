from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import staircase
from musclewire.errors import CallerError
from musclewire.experiment import staircase_within
from musclewire.experiment._speed_limits import checked_reference
from musclewire.sensing import SensingModel

STRAIN = SensingModel(15.0, 17.0, (0.036, -0.036), (0.036, -0.036), 0.0, 1.0)


def test_a_model_of_strain_gets_the_papers_staircase() -> None:
    assert staircase_within(STRAIN) == staircase()


@given(st.floats(1e-5, 1e3))
def test_the_top_is_round_and_every_level_is_within_the_models_range(largest: float) -> None:
    model = replace(
        STRAIN, quantity="force", heating_coefficients=(largest, -largest), cooling_coefficients=(largest, -largest)
    )
    levels = staircase_within(model).levels
    assert len(levels) == 11
    assert max(levels) <= 0.84 * largest * (1 + 1e-9)
    assert max(levels) > 0.75 * largest
    assert float(f"{max(levels):.2g}") == pytest.approx(max(levels), rel=1e-9)
    assert levels[0] == pytest.approx(max(levels) / 2)


def test_a_model_that_senses_too_little_gets_no_staircase() -> None:
    model = replace(STRAIN, quantity="force", heating_coefficients=(1.0, -0.3), cooling_coefficients=(1.0, -0.3))
    with pytest.raises(CallerError, match="no staircase fits"):
        staircase_within(model)


@pytest.mark.parametrize("wrong", [0.02, [0.01, 0.02], staircase])
def test_what_is_no_reference_is_told_what_makes_one(wrong: Any) -> None:
    with pytest.raises(CallerError, match=r"made by staircase.* or sampled_reference.*, not an? (float|list|function)"):
        checked_reference(STRAIN, wrong)
