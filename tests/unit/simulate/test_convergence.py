"""Finer steps and more grains lead to one answer, at the order that `python benchmarks/convergence.py` prints.

The distances are those of the benchmark: from a twenty times finer step, or from 2560 grains. That the one answer is
the right one is for test_plain_scipy_wire.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from convergence import COURSES, GRAINS, STEPS_S, grain_distances, observed_order, step_distances

COURSE = {course.name: course for course in COURSES}
TEMPERATURE, CONTRACTION, RESISTANCE = range(3)


@pytest.mark.parametrize("course", [pytest.param("slow loop", marks=pytest.mark.slow), "fast step", "sudden start"])
def test_the_error_of_the_time_step_is_of_first_order(course: str) -> None:
    """Temperature, contraction and resistance, root mean square over the course: order one is what the scheme has."""
    found = step_distances(COURSE[course], nanokelvins=2)
    order = observed_order(1.0 / np.array(STEPS_S), found.rms)
    assert (order >= 0.9).all(), order
    assert (order <= 1.2).all(), "more than the scheme can have: the reference is no reference"


@pytest.mark.parametrize("course", ["fast step", "sudden start"])
def test_even_the_worst_sample_of_a_sudden_start_comes_right(course: str) -> None:
    """A step that overshoots where a transformation starts moves one sample; the order of that is ragged and lower."""
    found = step_distances(COURSE[course], nanokelvins=2)
    order = observed_order(1.0 / np.array(STEPS_S), found.largest)
    assert (order >= 0.7).all(), order


@pytest.mark.slow
def test_at_the_default_step_the_slow_loop_is_right_to_a_hundredth_of_a_percent_of_strain() -> None:
    found = step_distances(COURSE["slow loop"], nanokelvins=2)
    assert found.largest[STEPS_S.index(1e-3), CONTRACTION] < 1e-4


@pytest.mark.slow
def test_more_grains_lead_to_one_loop_faster_than_in_proportion() -> None:
    """Classes as intervals are a piecewise linear distribution: between order one and two."""
    found = grain_distances(COURSE["slow loop"])
    order = observed_order(np.array(GRAINS, dtype=np.float64), found.rms)
    assert (order >= 1.4).all(), order
    assert (np.diff(found.rms, axis=0) < 0.0).all(), found.rms
    default = GRAINS.index(160)
    assert found.rms[default, CONTRACTION] < 3e-5
    assert found.rms[default, RESISTANCE] < 2e-4 * 17.0
    assert found.rms[default, TEMPERATURE] < 3e-3
