"""What may have drifted since the last home move is in the standard deviation of every estimate."""

from __future__ import annotations

from dataclasses import replace

import pytest

from musclewire.sensing import HomeMove, SensingModel

MODEL = SensingModel(13.5, 17.5, (0.0405, -0.04), (0.0395, -0.04), 0.05, 0.95, resistance_noise_ohm=0.0)


def homed(drift_ohm: float) -> SensingModel:
    found = (1.0, 0.0, 0.0, 0.0, 0.0, 8.0, 1.0, 0.1, drift_ohm)
    return replace(MODEL, home=HomeMove("2026-11-22T12:00:00+00:00", 1, None, 1.9, None, False, *found))


@pytest.mark.parametrize("drift_ohm", [0.01, 0.04])
def test_a_drift_of_resistance_counts_with_the_slope_of_the_curve(drift_ohm: float) -> None:
    _, before, _ = MODEL.curve().estimate(15.5)
    _, after, _ = homed(drift_ohm).curve().estimate(15.5)
    # 4 ohm span the curve's range.
    slope_per_ohm = (MODEL.quantity_max - MODEL.quantity_min) / 4.0
    assert (after**2 - before**2) ** 0.5 == pytest.approx(slope_per_ohm * drift_ohm, rel=1e-6)


def test_without_a_home_move_the_deviation_is_that_of_the_fit() -> None:
    assert homed(0.0).curve().estimate(15.5) == MODEL.curve().estimate(15.5)
