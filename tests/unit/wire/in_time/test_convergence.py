"""Finer steps lead to one answer at order two, and more grains to the fronts: `python benchmarks/convergence.py`.

The distances are those of the benchmark: from a much finer step, and of an ensemble of grains from the fronts. That the
one answer is the right one is for the grains of tests/grain_wire (test_kernel_accuracy.py).
"""

from __future__ import annotations

import numpy as np
import pytest
from convergence import (
    COURSES,
    GRAINS,
    STEPS_S,
    grain_distances,
    observed_order_of_grains,
    observed_order_of_steps,
    step_distances,
)

COURSE = {course.name: course for course in COURSES}
TEMPERATURE, CONTRACTION, RESISTANCE = range(3)


@pytest.mark.parametrize("course", [pytest.param("slow loop", marks=pytest.mark.slow), "fast step", "sudden start"])
def test_the_error_of_the_time_step_is_of_second_order(course: str) -> None:
    """Temperature, contraction and resistance, root mean square over the course, from 40 to 5 ms.

    Where a transformation starts within a step the order is lower: contraction and resistance have kinks there.
    """
    order = observed_order_of_steps(step_distances(COURSE[course]).rms)
    assert order[TEMPERATURE] >= 1.9, order
    assert (order >= 1.7).all(), order
    assert (order <= 2.3).all(), "more than the scheme can have: the reference is no reference"


@pytest.mark.parametrize("course", ["fast step", "sudden start"])
def test_even_the_worst_sample_of_a_sudden_start_comes_right(course: str) -> None:
    """A step that overshoots where a transformation starts moves one sample; the order of that is more ragged."""
    order = observed_order_of_steps(step_distances(COURSE[course]).largest)
    assert (order >= 1.5).all(), order


def test_a_slow_loop_in_one_step_a_sample_of_40_ms_is_right_to_a_millikelvin() -> None:
    largest = step_distances(COURSE["slow loop"]).largest[STEPS_S.index(40e-3)]
    assert largest[TEMPERATURE] < 1e-3
    assert largest[CONTRACTION] < 5e-6
    assert largest[RESISTANCE] < 1e-4


@pytest.mark.full
def test_more_grains_lead_to_the_fronts_faster_than_in_proportion() -> None:
    """Classes as intervals are a piecewise linear distribution: between order one and two."""
    found = grain_distances(COURSE["slow loop"])
    order = observed_order_of_grains(found.rms)
    assert (order >= 1.4).all(), order
    assert (np.diff(found.rms, axis=0) < 0.0).all(), found.rms
    default = GRAINS.index(160)
    assert found.rms[default, CONTRACTION] < 3e-5
    assert found.rms[default, RESISTANCE] < 2e-4 * 17.0
    assert found.rms[default, TEMPERATURE] < 3e-3
