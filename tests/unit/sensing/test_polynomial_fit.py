from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError, RecordingError
from musclewire.sensing import Branch, evaluate, normalised_resistance
from musclewire.sensing._branch_equations import average
from musclewire.sensing._polynomial_fit import choose_order, fit_points, fit_polynomial

FRACTION = np.linspace(0.0, 1.0, 150)
coefficient_lists = st.lists(st.floats(-1, 1), min_size=2, max_size=7)


def points_of(quantity: np.ndarray, share: np.ndarray = FRACTION):  # type: ignore[no-untyped-def]
    return fit_points(Branch(10.0 + share, quantity), 10.0, 11.0)


def test_the_least_resistance_is_zero_and_the_most_is_one() -> None:
    assert normalised_resistance(15.0, 15.0, 17.0) == 0.0
    assert normalised_resistance(17.0, 15.0, 17.0) == 1.0
    assert normalised_resistance(np.array([14.0, 16.0]), 15.0, 17.0).tolist() == [-0.5, 0.5]


@pytest.mark.parametrize(("low", "high"), [(17.0, 15.0), (15.0, 15.0), (0.0, 1.0), (1.0, float("nan"))])
def test_a_senseless_range_of_resistance_is_the_callers_fault(low: float, high: float) -> None:
    with pytest.raises(CallerError, match="the minimum below the maximum"):
        normalised_resistance(16.0, low, high)


@given(coefficient_lists, st.floats(-2, 2))
def test_horner_agrees_with_the_sum_of_powers_for_scalars_and_arrays(coefficients: list[float], at: float) -> None:
    expected = sum(c * at**power for power, c in enumerate(coefficients))
    assert evaluate(coefficients, at) == pytest.approx(expected, abs=1e-9)
    assert evaluate(coefficients, np.array([[at]]))[0, 0] == pytest.approx(expected, abs=1e-9)


@settings(deadline=None)
@given(coefficient_lists)
def test_a_polynomial_is_recovered_from_its_own_values(coefficients: list[float]) -> None:
    fit = fit_polynomial(points_of(evaluate(coefficients, FRACTION)), len(coefficients) - 1)
    assert fit.coefficients == pytest.approx(coefficients, abs=1e-8)
    assert max(fit.standard_errors) < 1e-8


def test_standard_errors_tell_the_scatter_of_repeated_fits() -> None:
    random = np.random.default_rng(4)
    truth = evaluate([0.03, -0.02, -0.005], FRACTION)
    fits = [fit_polynomial(points_of(truth + 1e-3 * random.normal(size=FRACTION.size)), 2) for _ in range(300)]
    scatter = np.std([fit.coefficients for fit in fits], axis=0)
    told = np.mean([fit.standard_errors for fit in fits], axis=0)
    assert told == pytest.approx(scatter, rel=0.2)


def test_correlated_residuals_widen_the_standard_errors() -> None:
    bent = fit_polynomial(points_of(np.sin(9 * FRACTION)), 3)
    shuffled = np.random.default_rng(0).permutation(np.sin(9 * FRACTION) - evaluate(bent.coefficients, FRACTION))
    rough = fit_polynomial(points_of(evaluate(bent.coefficients, FRACTION) + shuffled), 3)
    assert min(np.array(bent.standard_errors) / np.array(rough.standard_errors)) > 1.5


def test_uneven_sampling_has_no_say_in_the_fit() -> None:
    crowded = np.unique(np.concatenate([np.linspace(0, 0.1, 3000), np.linspace(0, 1, 120)]))
    curve = np.sqrt(1.05 - FRACTION)
    even = fit_polynomial(points_of(curve), 2)
    uneven = fit_polynomial(points_of(np.sqrt(1.05 - crowded), crowded), 2)
    unweighted = np.polynomial.polynomial.polyfit(crowded, np.sqrt(1.05 - crowded), 2)
    gap = np.abs(evaluate(even.coefficients, FRACTION) - evaluate(uneven.coefficients, FRACTION)).max()
    careless = np.abs(evaluate(even.coefficients, FRACTION) - evaluate(unweighted.tolist(), FRACTION)).max()
    assert gap < 0.15 * careless


def test_too_few_points_name_the_largest_order() -> None:
    share = np.linspace(0, 1, 4)
    with pytest.raises(RecordingError, match=r"order 4 needs at least 5 points and the cooling branch has 4.*is 3"):
        fit_polynomial(points_of(share, share), 4, "cooling")
    exact = fit_polynomial(points_of(share**3, share), 3)
    assert exact.spare_points == 0
    assert exact.standard_errors == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("order", [0, -1, 16, True, 2.0])
def test_an_order_outside_one_to_fifteen_is_the_callers_fault(order: int) -> None:
    with pytest.raises(CallerError, match="from 1 to 15"):
        fit_polynomial(points_of(FRACTION), order)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_cross_validation_finds_the_order_that_made_the_data(order: int) -> None:
    random = np.random.default_rng(order)
    truth = np.polynomial.Chebyshev([1.0] * (order + 1), domain=[0, 1])(FRACTION)
    branches = [points_of(truth + 0.02 * random.normal(size=FRACTION.size)) for _ in range(2)]
    assert choose_order(branches) == order


def test_the_average_is_the_mean_of_coefficients() -> None:
    assert average([1.0, 2.0], [3.0, 0.0]) == (2.0, 1.0)
    with pytest.raises(CallerError, match="fit both alike"):
        average([1.0], [1.0, 2.0])
