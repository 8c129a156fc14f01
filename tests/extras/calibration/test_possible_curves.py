"""How a spread of possible curves is described: by a common factor and a common offset."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from musclewire.extras.calibration._resistance_alone.possible_curves import (
    GRID,
    PossibleCurves,
    combined_std,
    scale_and_offset_std,
)
from musclewire.extras.calibration._resistance_alone.spreads import spreads
from musclewire.parameters import load_alloy, load_bench, load_wire

STROKE = 0.04
# Falls from the whole stroke at no resistance to none at the highest.
MODEL: Any = SimpleNamespace(
    normalised_min=0.0, normalised_max=1.0, quantity_max=STROKE, average_coefficients=np.array([STROKE, -STROKE])
)


@pytest.mark.parametrize(("factor_std", "offset_std"), [(0.05, 0.0), (0.0, 0.001), (0.05, 0.001)])
def test_curves_that_differ_by_a_factor_and_an_offset_are_described_by_their_deviations(
    factor_std: float, offset_std: float
) -> None:
    # Each sign with each: both deviations are exact in the sample, and independent of each other.
    signs = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]) * np.sqrt(3.0 / 4.0)
    curve = STROKE * (1.0 - GRID)
    drawn = [curve * (1.0 + factor_std * first) + offset_std * second for first, second in signs]
    curves = PossibleCurves(np.array([[one, one] for one in drawn]), np.full(4, STROKE), np.zeros((4, 1)))
    assert scale_and_offset_std(curves, MODEL) == pytest.approx((factor_std, offset_std), abs=1e-9)


def test_two_measurements_of_one_number_combine_by_inverse_variance() -> None:
    """3-4-5 upside down: 1/9 + 1/16 = 25/144."""
    assert combined_std(3.0, 4.0) == pytest.approx(12.0 / 5.0)
    assert combined_std(3.0, 1e9) == pytest.approx(3.0)


def test_every_spread_of_a_spool_is_that_of_a_number_of_wire_alloy_or_bench() -> None:
    wire = load_wire("paper-100um")
    known = (*load_alloy(wire.alloy).values(), *wire.values(), *load_bench("paper").values())
    assert spreads()["spreads"].keys() <= set(known)
