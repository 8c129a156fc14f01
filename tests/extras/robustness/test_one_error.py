# ruff: noqa: E402 - a package that may be missing is asked for first
"""The error that `fit` and `estimate` print of a wire's own loop, against the same computed apart."""

import numpy as np
import pytest
from tests.tools import require_package

require_package("musclewire_robustness", "pip install ./studies/robustness")

from musclewire_robustness.characterizing import slow_loop
from musclewire_robustness.population import drawn_wire, held_out_seeds

from musclewire.identify import estimate, fit
from musclewire.signals import Recording


def apart(loop: Recording, columns, model) -> str:
    """Return the last line of fit and estimate, computed from the columns alone."""
    strain = loop["displacement_m"] / 0.07
    counted = (columns["valid"] > 0.0) & (strain >= model.quantity_min)
    off_pct = 100.0 * (columns["estimated_strain"] - strain)[counted] / model.measured_stroke
    # The fitted loop is the last: an aged wire does not come all the way back from its first one.
    last = loop["cycle"] == loop["cycle"].max()
    assert model.measured_stroke == pytest.approx(np.ptp(strain[last]), rel=0.01)
    return (
        f"estimator filter: error {np.sqrt(np.mean(off_pct**2)):.3f} % rms, {np.abs(off_pct).max():.3f} % largest, of "
        f"the measured stroke; {100 * np.mean(np.abs(off_pct) > 5.0):.2f} % of the samples that count are more than "
        "5 % wrong"
    )


def judge(seed: int) -> None:
    loop = slow_loop(drawn_wire(seed))
    model = fit(loop)
    report = estimate(model, loop)
    assert report.summary().splitlines()[-1] == apart(loop, estimate(model, loop, estimator="filter").columns, model)
    # A loop holds each of these wires.
    assert model.holds
    assert report.wrong_pct == 0.0


@pytest.mark.slow
def test_a_wires_error_is_what_is_computed_apart() -> None:
    judge(held_out_seeds()[0])


@pytest.mark.full
@pytest.mark.parametrize("seed", held_out_seeds()[1:13])
def test_the_errors_of_twelve_wires_are_what_is_computed_apart(seed: int) -> None:
    judge(seed)
