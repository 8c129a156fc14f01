"""A correction is a Gaussian of two numbers: each piece of evidence narrows it as Bayes' rule says, in any order."""

from __future__ import annotations

from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.sensing import Correction, SensingModel, by_scale_of, with_resistances

DOUBTED = Correction(scale_variance=0.03**2, zero_variance=6e-4**2)
EVIDENCE = st.lists(
    st.tuples(st.floats(-1e-3, 1e-3), st.floats(-0.3, 0.3), st.sampled_from([-1.0, 0.0]), st.floats(1e-10, 1e-6)),
    max_size=5,
)
MODEL = SensingModel(17.0, 20.0, (0.03, -0.03), (0.03, -0.03), 0.0, 1.0, slow_loop=((0.0, 0.1, 19.9), (1.0, 0.5, 17.2)))


@given(EVIDENCE)
def test_evidence_combines_as_weighted_least_squares(evidence: list[tuple[float, float, float, float]]) -> None:
    """The oracle is the posterior of all at once, in its information form."""
    found, information, vector = DOUBTED, np.diag([1.0 / 0.03**2, 1.0 / 6e-4**2]), np.zeros(2)
    for missed, by_scale, by_zero, variance in evidence:
        row, now = np.array([by_scale, by_zero]), np.array([log(found.scale), found.zero])
        found = found.updated(missed, by_scale, by_zero, variance)
        information, vector = (
            information + np.outer(row, row) / variance,
            vector + row * (row @ now - missed) / variance,
        )
    covariance = np.linalg.inv(information)
    assert [log(found.scale), found.zero] == pytest.approx((covariance @ vector).tolist(), rel=1e-5, abs=1e-9)
    assert found.scale_variance == pytest.approx(covariance[0, 0], rel=1e-5)
    assert found.covariance == pytest.approx(covariance[0, 1], rel=1e-5, abs=1e-12)
    assert found.zero_variance == pytest.approx(covariance[1, 1], rel=1e-5)
    assert found.variance(by_scale_of(MODEL)) >= 0.0


def test_what_is_believed_stays_whatever_is_missed() -> None:
    assert Correction().is_believed
    assert Correction().updated(1e-3, -0.2, -1.0, 1e-8) == Correction()


@given(st.floats(0.97, 1.03))
def test_a_scale_moves_all_resistances_of_a_model_and_no_other_number(scale: float) -> None:
    moved = Correction(scale=scale).applied_to(MODEL)
    assert moved.strain(18.5 / scale) == pytest.approx(float(MODEL.strain(18.5)), abs=1e-9)
    assert [row[2] * scale for row in moved.slow_loop] == pytest.approx([row[2] for row in MODEL.slow_loop])
    assert with_resistances(moved, scale, 0.0).resistance_max_ohm == pytest.approx(MODEL.resistance_max_ohm)
    assert (moved.heating_coefficients, moved.quantity_max) == (MODEL.heating_coefficients, MODEL.quantity_max)


def test_half_a_percent_of_resistance_is_three_percent_of_the_stroke() -> None:
    assert 0.005 * by_scale_of(MODEL) == pytest.approx(-0.005 * 18.5 / 3.0 * MODEL.stroke)
