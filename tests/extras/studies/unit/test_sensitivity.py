"""Indices of known functions: Ishigami's and a linear one have closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from musclewire.arrays import FloatArray
from musclewire.extras.studies._design import StudyDesign, design_of
from musclewire.extras.studies._sensitivity import sensitivity_of
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter

A, B = 7.0, 0.1


def wide(probability: FloatArray) -> FloatArray:
    return math.pi * (2.0 * probability - 1.0)


def ishigami(design: StudyDesign) -> FloatArray:
    x, y, z = design.samples.T[:3]
    return np.asarray(np.sin(x) + A * np.sin(y) ** 2 + B * z**4 * np.sin(x))


def closed_form() -> tuple[list[float], list[float]]:
    """First and total indices of Ishigami's function (Saltelli et al., Global Sensitivity Analysis, 2008, 4.9)."""
    first = 0.5 * (1.0 + B * math.pi**4 / 5.0) ** 2
    second = A**2 / 8.0
    together = B**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + together
    return [first / whole, second / whole, 0.0], [(first + together) / whole, second / whole, together / whole]


def three(method: str, samples: int) -> StudyDesign:
    return design_of([SampledParameter(name, "1", wide) for name in "xyz"], method, samples, 1)


def test_saltellis_design_gives_the_closed_forms_of_ishigamis_function() -> None:
    design = three("saltelli", 2048)
    rows = sensitivity_of(design, {"f": ishigami(design)}, 1)
    first, total = closed_form()
    assert [row.first for row in rows] == pytest.approx(first, abs=0.02)
    assert [row.total for row in rows] == pytest.approx(total, abs=0.02)
    assert [row.parameter for row in rows] == ["x", "y", "z"]


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "halton", "random"])
def test_any_other_sample_gives_the_first_indices(method: str) -> None:
    # The fourth has no effect. In four dimensions RBD-FAST takes a Sobol sequence's third for its first.
    design = design_of([SampledParameter(name, "1", wide) for name in "xyzw"], method, 4096, 1)
    rows = sensitivity_of(design, {"f": ishigami(design)}, 1)
    assert [row.first for row in rows] == pytest.approx([*closed_form()[0], 0.0], abs=0.04)
    # The third acts by its interaction with the first alone: its first index is 0, PAWN's is not.
    found = [row.pawn or 0.0 for row in rows]
    assert found[2] > 2.0 * found[3]


def test_the_indices_of_a_grid_are_exact() -> None:
    x, y = np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 9)
    design = design_of([GridAxis("x", "1", tuple(x.tolist())), GridAxis("y", "1", tuple(y.tolist()))], "random", 1, 1)
    values = (3.0 * x[:, None] + 2.0 * y[None, :] + x[:, None] * y[None, :]).ravel()
    rows = sensitivity_of(design, {"f": values}, 1)
    parts = [9.0 * x.var(), 4.0 * y.var(), x.var() * y.var()]
    assert [row.first for row in rows] == pytest.approx([parts[0] / sum(parts), parts[1] / sum(parts)])


@pytest.mark.parametrize("method", ["saltelli", "sobol"])
def test_over_a_grid_all_indices_are_of_one_variance(method: str) -> None:
    """Of 3 g + 2 x + g x with g of -1, 0, 1 and x uniform from -1 to 1; y does nothing."""
    sampled = [SampledParameter(name, "1", lambda probability: 2.0 * probability - 1.0) for name in "xy"]
    design = design_of([GridAxis("g", "1", (-1.0, 0.0, 1.0)), *sampled], method, 1024, 1)
    g, x = np.array([-1.0, 0.0, 1.0])[:, None], design.samples[:, 0]
    rows = sensitivity_of(design, {"f": (3.0 * g + 2.0 * x + g * x).ravel()}, 1)
    of_g, of_x, together = 6.0, 4.0 / 3.0, 2.0 / 9.0
    whole = of_g + of_x + together
    assert [row.parameter for row in rows] == ["g", "x", "y"]
    assert [row.first for row in rows] == pytest.approx([of_g / whole, of_x / whole, 0.0], abs=0.02)
    if method == "saltelli":
        assert [row.total for row in rows] == [
            None,
            pytest.approx((of_x + together) / whole, abs=0.02),
            pytest.approx(0.0, abs=0.02),
        ]
    assert 0.0 < float(rows[0].first_error or 0.0) < 0.05


def test_failed_runs_are_left_out_of_a_sample_and_end_a_complete_design() -> None:
    design = three("sobol", 4096)
    values = ishigami(design)
    values[::17] = np.nan
    assert [row.first for row in sensitivity_of(design, {"f": values}, 1)] == pytest.approx(closed_form()[0], abs=0.04)
    complete = three("saltelli", 64)
    values = ishigami(complete)
    values[3] = np.nan
    assert sensitivity_of(complete, {"f": values}, 1) == []


def test_a_constant_quantity_and_a_series_have_no_indices() -> None:
    design = three("sobol", 64)
    assert sensitivity_of(design, {"f": np.ones(64), "g": np.ones((64, 3))}, 1) == []
