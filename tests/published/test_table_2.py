"""Table 2 of Lan and Fan 2010: six resistances, the strain of both branches, and R_min, R_max of Fig. 9."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.sensing import SensingModel, fit_branches, normalised_resistance

DESIRED_STRAIN = np.array([1.5, 1.8, 2.1, 2.4, 2.7, 3.0]) / 100
REQUIRED_RESISTANCE_OHM = np.array([16.737, 16.497, 16.274, 16.055, 15.825, 15.577])
STRAIN_HEATING = np.array([1.506, 1.819, 2.112, 2.398, 2.697, 3.034]) / 100
STRAIN_COOLING = np.array([1.493, 1.781, 2.088, 2.402, 2.703, 2.966]) / 100
RESISTANCE_MIN_OHM = 15.1526
RESISTANCE_MAX_OHM = 17.4945


def table_model(order: int = 3) -> SensingModel:
    return fit_branches(
        (REQUIRED_RESISTANCE_OHM, STRAIN_HEATING),
        (REQUIRED_RESISTANCE_OHM, STRAIN_COOLING),
        order,
        resistance_min_ohm=RESISTANCE_MIN_OHM,
        resistance_max_ohm=RESISTANCE_MAX_OHM,
    )


def test_the_printed_resistance_for_one_and_a_half_percent_lies_at_two_thirds_of_the_segment() -> None:
    normalised = normalised_resistance(16.737, RESISTANCE_MIN_OHM, RESISTANCE_MAX_OHM)
    assert normalised == pytest.approx(1.5844 / 2.3419, abs=1e-12)


def test_the_desired_strain_is_the_mean_of_the_printed_branches() -> None:
    """Eq. 5 holds in the printed numbers themselves, to their rounding."""
    assert np.abs((STRAIN_HEATING + STRAIN_COOLING) / 2 - DESIRED_STRAIN).max() <= 0.0006 / 100


@pytest.mark.parametrize("order", [3, 4, 5])
def test_both_printed_branches_are_reproduced(order: int) -> None:
    model = table_model(order)
    assert model.strain_heating(REQUIRED_RESISTANCE_OHM) == pytest.approx(STRAIN_HEATING, abs=1e-4)
    assert model.strain_cooling(REQUIRED_RESISTANCE_OHM) == pytest.approx(STRAIN_COOLING, abs=1e-4)


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_inverting_the_average_returns_the_required_resistances(order: int) -> None:
    model = table_model(order)
    assert model.resistance_ohm(DESIRED_STRAIN) == pytest.approx(REQUIRED_RESISTANCE_OHM, abs=0.01)
    one_by_one = [model.resistance_ohm(float(strain)) for strain in DESIRED_STRAIN]
    assert one_by_one == pytest.approx(REQUIRED_RESISTANCE_OHM, abs=0.01)


def test_the_valid_range_is_that_of_the_table_and_not_extrapolated() -> None:
    model = table_model()
    assert model.normalised_min == pytest.approx(0.1812, abs=1e-4)
    assert model.normalised_max == pytest.approx(0.6765, abs=1e-4)
    assert not model.estimate(17.2).valid
    assert model.estimate(16.2).valid


def test_order_six_is_refused_for_six_points_naming_the_largest_possible() -> None:
    with pytest.raises(RecordingError, match="largest order possible is 5"):
        table_model(6)
