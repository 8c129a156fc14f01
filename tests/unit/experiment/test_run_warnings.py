"""A run in which friction holds the wire says so, and no other does."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.experiment import friction_warnings, run_warnings
from musclewire.signals import MetadataValue, Recording


def stated(**facts: MetadataValue) -> Recording:
    return Recording({"time_s": np.arange(3.0), "force_n": np.full(3, 9.0)}, facts)


@pytest.mark.parametrize("facts", [{}, {"friction_held_m": 1.0}, {"friction_held_m": 0.0, "leg_length_m": 0.07},
                                   {"friction_held_m": 6.9e-6, "leg_length_m": 0.07}])  # fmt: skip
def test_no_warning_without_slack_or_without_what_says_how_much_it_is(facts: dict[str, MetadataValue]) -> None:
    assert friction_warnings(stated(**facts)) == ()


def test_the_warning_says_how_far_and_what_to_do() -> None:
    (warning,) = friction_warnings(stated(friction_held_m=0.74e-3, leg_length_m=0.07))
    assert warning.startswith("friction holds the wire: ")
    assert "0.74 mm" in warning
    assert "more pretension" in warning


@pytest.mark.parametrize(("error_k", "step_s", "said"), [(1.3, 0.5, "fixed steps of 500 ms"), (0.2, 0.0, "tolerance")])
def test_steps_that_show_are_named_and_those_within_the_tolerance_are_not(
    error_k: float, step_s: float, said: str
) -> None:
    (warning,) = run_warnings(stated(step_error_k=error_k, time_step_s=step_s))
    assert said in warning
    assert "time_step_s" in warning
    assert run_warnings(stated(step_error_k=0.005, time_step_s=step_s)) == ()
